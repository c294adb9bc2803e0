// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** A point of the mesh's surface, by its place in the source mesh (surface.proto, SurfacePoint). */
export interface SurfacePoint {
  /** Index of the face in the source mesh. */
  readonly face: number;
  /** Three corners of that face. */
  readonly corners: readonly [number, number, number];
  /** Barycentrics of the point in the triangle of the corners, with sum 1. */
  readonly barycentrics: readonly [number, number, number];
  /** Deformed position in world units. */
  readonly position: readonly [number, number, number];
  /** Deformed unit normal; absent if it is undefined. */
  readonly normal?: readonly [number, number, number];
}

/** One change of control points, or of the scene's strength. World units; no index occurs twice. */
export type LatticeEdit =
  | { readonly kind: 'move'; readonly indices: Uint32Array; readonly offset: readonly [number, number, number] }
  /** 4 x 4, column-major, affine: acts on column vectors in world space. */
  | { readonly kind: 'transform'; readonly indices: Uint32Array; readonly matrix: Float64Array }
  /** x y z per index. */
  | { readonly kind: 'set'; readonly indices: Uint32Array; readonly positions: Float64Array }
  /** How much of the deformation the scene takes, 0 to 1. */
  | { readonly kind: 'strength'; readonly strength: number }
  /** The smallest move of control points that moves surface points to targets, x y z each. */
  | { readonly kind: 'drag'; readonly points: readonly SurfacePoint[]; readonly targets: Float64Array };
