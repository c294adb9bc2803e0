// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The place of a mesh at rest in its lattice: inside, or beyond some faces of the frame, where nothing moves it.
import { AXES, domain, frameEdges, placeOf, type Axis, type LatticeStructure } from './grid';
import { indicesTo } from './index_sets';
import { add, coordinates, distance, length, pointAt, sub, type Vec3 } from './vec';

const NOTHING = 1e-9; // of the frame's extent

/** A box in fractions of the frame: 0 to 1 is the lattice's own extent along an axis. */
type Fractions = readonly [axis: Range, axis: Range, axis: Range];
type Range = readonly [begin: number, end: number];

export interface MeshExtent {
  /** Bounds at rest, in world units. */
  readonly min: Vec3;
  readonly max: Vec3;
  /** Whether some of its patches lie outside the frame, and whether some meet others at a face of the frame. */
  readonly outside: boolean;
  readonly acrossFaces: boolean;
}

/** A face of the frame: the begin or the end of an axis. */
interface Face {
  readonly axis: Axis;
  readonly end: boolean;
}

/** The box around the mesh, as fractions of the frame. */
function extentInFrame({ frame }: LatticeStructure, { min, max }: MeshExtent): Fractions {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => {
    const at = AXES.map((axis) => ((corner >> axis) & 1 ? max[axis] : min[axis])) as unknown as Vec3;
    return coordinates(frameEdges(frame), sub(at, frame.origin));
  });
  return AXES.map((axis) => {
    const along = corners.map((corner) => corner[axis]);
    return [Math.min(...along), Math.max(...along)] as const;
  }) as unknown as Fractions;
}

/** The control points on the faces of the frame beyond which the mesh goes on. */
export function pointsOnCrossedFaces(structure: LatticeStructure, extent: MeshExtent): number[] {
  const within = extentInFrame(structure, extent);
  const faces: Face[] = AXES.flatMap((axis) => [
    ...(within[axis][0] < -NOTHING ? [{ axis, end: false }] : []),
    ...(within[axis][1] > 1 + NOTHING ? [{ axis, end: true }] : []),
  ]);
  const { size } = structure;
  return indicesTo(size[0] * size[1] * size[2]).filter((index) =>
    faces.some(({ axis, end }) => placeOf(size, index)[axis] === (end ? size[axis] - 1 : 0)));
}

/** Those of `candidates` whose influence reaches the mesh. */
export function pointsThatReach(structure: LatticeStructure, extent: MeshExtent, candidates: readonly number[]): number[] {
  const { size, degree, knots } = structure;
  const within = extentInFrame(structure, extent);
  const reaches = (index: number): boolean => AXES.every((axis) => {
    const [begin, end] = domain(structure, axis);
    const i = placeOf(size, index)[axis];
    const fraction = (knot: number): number => (knot - begin) / (end - begin);
    return fraction(knots[axis][i]) <= within[axis][1] && fraction(knots[axis][i + degree[axis] + 1]) >= within[axis][0];
  });
  return candidates.filter(reaches);
}

/** Those of `candidates` that are not where they are at `rest`. */
export function movedPoints({ frame }: LatticeStructure, rest: Float64Array, candidates: readonly number[], points: Float64Array): number[] {
  const least = NOTHING * length(frameEdges(frame).reduce(add));
  return candidates.filter((index) => distance(pointAt(points, index), pointAt(rest, index)) > least);
}
