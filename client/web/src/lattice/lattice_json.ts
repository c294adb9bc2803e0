// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices in files: the proto3 JSON of latticed.v1.Lattice, as `latticectl lattice` writes and reads it. Doubles
// come back with the same bits, but for a minus zero, which JSON.stringify writes as 0. Reading takes what that message
// may leave out: knots and control points.

import { AXIS_NAMES, pointCount, refusalOfAxes, type Axes, type LatticeStructure } from './grid';
import { clampedUniformKnots, identityPoints, knotVectors } from './identity';
import { Lattice } from './lattice';
import type { Vec3 } from './vec';

const FIELDS = ['frame', 'degree', 'size', 'knotsU', 'knotsV', 'knotsW', 'controlPoints'];
const KNOT_FIELDS = ['knotsU', 'knotsV', 'knotsW'] as const;

const vectorJson = ([x, y, z]: Vec3): object => ({ x, y, z });
const axesJson = ([u, v, w]: Axes): object => ({ u, v, w });

export function latticeToJson(lattice: Lattice): string {
  const { frame, degree, size, knots } = lattice;
  const message = {
    frame: { origin: vectorJson(frame.origin), u: vectorJson(frame.u), v: vectorJson(frame.v), w: vectorJson(frame.w) },
    degree: axesJson(degree),
    size: axesJson(size),
    knotsU: Array.from(knots[0]),
    knotsV: Array.from(knots[1]),
    knotsW: Array.from(knots[2]),
    controlPoints: Array.from(lattice.points),
  };
  return JSON.stringify(message, null, 1) + '\n';
}

/** Throws an Error whose message tells a person what is wrong with the file. */
export function latticeFromJson(text: string): Lattice {
  const message = parseObject(text);
  for (const name of Object.keys(message)) {
    if (!FIELDS.includes(name)) throw new Error(`"${name}" is no field of a lattice.`);
  }
  const degree = readAxes(message['degree'], [2, 2, 2]);
  const size = readAxes(message['size'], [4, 4, 4]);
  const refusal = refusalOfAxes(size, degree);
  if (refusal !== undefined) throw new Error(refusal);

  const structure: LatticeStructure = {
    degree,
    size,
    knots: knotVectors((axis) => readKnots(message, axis, degree[axis], size[axis])),
    frame: readFrame(message['frame']),
  };
  const points = readNumbers(message, 'controlPoints', 3 * pointCount(size));
  const { frame, knots } = structure;
  return new Lattice(
    frame,
    degree,
    size,
    knots,
    points === undefined ? identityPoints(structure) : Float64Array.from(points),
  );
}

function parseObject(text: string): Record<string, unknown> {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    throw new Error('The file is not JSON.');
  }
  if (typeof value !== 'object' || value === null || Array.isArray(value)) {
    throw new Error('The file is not the JSON of a lattice.');
  }
  return value as Record<string, unknown>;
}

/** A number of an object's field; what proto3 JSON leaves out is 0. */
function readNumber(value: unknown, name: string): number {
  const number = (value as Record<string, unknown> | undefined)?.[name] ?? 0;
  if (typeof number !== 'number' || !Number.isFinite(number)) throw new Error(`"${name}" is not a finite number.`);
  return number;
}

function readAxes(value: unknown, unset: Axes): Axes {
  if (value === undefined) return unset;
  return AXIS_NAMES.map((name) => readNumber(value, name)) as unknown as Axes;
}

function readFrame(value: unknown): LatticeStructure['frame'] {
  if (typeof value !== 'object' || value === null) throw new Error('The lattice has no "frame".');
  const vector = (name: string): Vec3 => {
    const field = (value as Record<string, unknown>)[name];
    return [readNumber(field, 'x'), readNumber(field, 'y'), readNumber(field, 'z')];
  };
  return { origin: vector('origin'), u: vector('u'), v: vector('v'), w: vector('w') };
}

function readKnots(message: Record<string, unknown>, axis: 0 | 1 | 2, degree: number, size: number): Float64Array {
  const name = KNOT_FIELDS[axis];
  const knots = readNumbers(message, name, size + degree + 1);
  if (knots?.some((knot, i) => i > 0 && knot < knots[i - 1])) throw new Error(`"${name}" must not decrease.`);
  return knots === undefined ? clampedUniformKnots(degree, size) : Float64Array.from(knots);
}

/** Undefined where the field is missing or empty, which means its default. */
function readNumbers(message: Record<string, unknown>, name: string, count: number): number[] | undefined {
  const value = message[name];
  if (value === undefined || (Array.isArray(value) && value.length === 0)) return undefined;
  if (!Array.isArray(value) || !value.every((x) => typeof x === 'number' && Number.isFinite(x))) {
    throw new Error(`"${name}" is not a list of finite numbers.`);
  }
  if (value.length !== count) {
    throw new Error(`"${name}" has ${value.length} numbers; this size and degree need ${count}.`);
  }
  return value as number[];
}
