// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../../lattice/vec';

/** A span in places (patches.proto). */
export const KNOT = 65_535;
/** The weight of a vertex that follows the lattice (patches.proto). */
export const WEIGHT_ONE = 65_535;

/** Vertices and edges that patches inside and outside the frame share (patches.proto, PatchSeams). */
export interface Seams {
  /** Six numbers per seam: i_0 i_1 j_0 j_1 k_0 k_1, both ends included. */
  readonly ranges: Uint32Array;
  readonly vertices: Uint32Array;
  readonly vertexSeams: Uint32Array;
  /** Three per vertex of `vertices`. */
  readonly outsidePlaces: Int32Array;
  readonly edges: Uint32Array;
  readonly edgeSeams: Uint32Array;
  /** x y z per control point. */
  readonly identityPoints: Float64Array;
}

/** A patch plan as patches.proto defines it. Immutable. */
export interface PatchPlan {
  readonly topologyId: string;
  readonly patchCount: number;
  /** The first patches; those behind them lie outside the frame. */
  readonly insideCount: number;
  readonly vertexCount: number;
  readonly edgeCount: number;
  readonly hasNormals: boolean;
  /** What positions are relative to, in world units. */
  readonly origin: Vec3;
  /** Lowest and highest corner of the outside box; absent if no patch is outside. */
  readonly outside: readonly [Vec3, Vec3] | undefined;
  /** What edge bounds are multiples of, in world units. */
  readonly curvatureUnit: number;
  /** Three vertices per patch. */
  readonly corners: Uint32Array;
  /** Three places per vertex: in the lattice if a patch inside the frame uses it, else in the outside box. */
  readonly places: Int32Array;
  /** Three rest normals per patch. */
  readonly cornerNormals: Uint32Array;
  /** x y z of each rest normal; of unit length with facet normals. */
  readonly restNormals: Float32Array;
  /** Three edges per patch. */
  readonly edges: Uint32Array;
  /** How many edges the patches before a patch use; one entry more than patches. */
  readonly edgesBefore: Uint32Array;
  readonly seams: Seams;
  /** Of each vertex, 0 to 65535; absent if all vertices follow the lattice. */
  readonly weights: Uint16Array | undefined;
  /** x y z for each patch: the gradient of the weight, per world unit; absent without weights or without normals. */
  readonly slopes: Float32Array | undefined;
}

/** The span of a patch inside the frame, from the places of its corners on an axis (patches.proto, Places). */
export function spanOf(a: number, b: number, c: number): number {
  return Math.max(0, Math.ceil((a + b + c) / (3 * KNOT)) - 1);
}
