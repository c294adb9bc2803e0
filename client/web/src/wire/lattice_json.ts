// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices in files: the proto3 JSON of latticed.v1.Lattice, as `latticectl lattice` writes and reads it. Doubles keep
// their bits. A file may leave out degree, size, knots and control points.
import { fromJsonString, toJsonString } from '@bufbuild/protobuf';
import { LatticeSchema, type Lattice as LatticeMessage } from 'latticed/v1/lattice_pb';
import { pointCount, refusalOfAxes, type LatticeStructure } from '../lattice/grid';
import { clampedUniformKnots, DEFAULT_FIT, identityPoints, knotVectors } from '../lattice/identity';
import { Lattice } from '../lattice/lattice';
import { fromLattice, toGivenLattice } from './lattice_message';

export function latticeToJson(lattice: Lattice): string {
  return toJsonString(LatticeSchema, fromLattice(lattice), { alwaysEmitImplicit: true, prettySpaces: 1 }) + '\n';
}

/** Throws an Error whose message tells a person what is wrong with the file. */
export function latticeFromJson(text: string): Lattice {
  const message = parse(text);
  const given = toGivenLattice(message);
  const degree = message.degree ? given.degree : DEFAULT_FIT.degree;
  const size = message.size ? given.size : DEFAULT_FIT.size;
  const refusal = refusalOfAxes(size, degree);
  if (refusal !== undefined) throw new Error(refusal);
  if (message.frame === undefined) throw new Error('The lattice has no "frame".');

  const knots = knotVectors((axis) => {
    const name = (['knotsU', 'knotsV', 'knotsW'] as const)[axis];
    const vector = allOrNone(name, given.knots[axis], size[axis] + degree[axis] + 1);
    if (vector?.some((knot, i) => i > 0 && knot < vector[i - 1])) throw new Error(`"${name}" must not decrease.`);
    return vector ?? clampedUniformKnots(degree[axis], size[axis]);
  });
  const structure: LatticeStructure = { degree, size, knots, frame: given.frame };
  Object.entries(given.frame).forEach(([name, vector]) => checkFinite(name, vector as readonly number[]));
  const points = allOrNone('controlPoints', given.points, 3 * pointCount(size)) ?? identityPoints(structure);
  return new Lattice(structure.frame, degree, size, knots, points, given.outside);
}

function parse(text: string): LatticeMessage {
  try {
    return fromJsonString(LatticeSchema, text);
  } catch (error) {
    throw new Error(`The file is not the JSON of a lattice: ${(error as Error).message}.`);
  }
}

/** Undefined if there are no numbers: the default is used. */
function allOrNone(name: string, values: Float64Array, count: number): Float64Array | undefined {
  if (values.length === 0) return undefined;
  if (values.length !== count) throw new Error(`"${name}" has ${values.length} numbers; this size and degree need ${count}.`);
  checkFinite(name, values);
  return values;
}

function checkFinite(name: string, values: ArrayLike<number>): void {
  if (!Array.from(values).every(Number.isFinite)) throw new Error(`"${name}" has a number that is not finite.`);
}
