// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Lattice } from '../lattice/lattice';
import type { FlatPatches } from './largest_distance';

/** Facts about patches besides their points: the shape at rest, texture coordinates, the shape if only vertices moved, weights. */
export type PatchFacts = 'rest' | 'uvs' | 'flat' | 'weights';

/** The places of patches in the source mesh (surface.proto, TopologyPart). */
export interface PatchOrigins {
  /** Three per patch: corners of the source triangle. */
  readonly corners: Uint32Array;
  /** Nine per patch: for its corners 0, 1, 2 the barycentrics in that triangle. */
  readonly barycentrics: Float64Array;
  /** Three per patch: the mesh's vertices at these corners. Absent from servers that do not tell them. */
  readonly vertices?: Uint32Array | undefined;
  /** Three per patch: the weights of these vertices. Absent: all are 1. */
  readonly weights?: Float32Array | undefined;
}

/** Corners of all patches before any deformation. */
export type RestCorners = FlatPatches;

/** Data that the surface fetches only when a look needs it. */
export interface PatchSource {
  origins(topologyId: string): Promise<PatchOrigins>;
  restCorners(): Promise<RestCorners>;
  /** Number of the knot box of a world point at rest, or -1 outside the frame. */
  boxOf(x: number, y: number, z: number): number;
  /** The lattice that the page shows; another object once its structure has changed. */
  lattice(): Lattice;
}
