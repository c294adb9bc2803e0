// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Where patches come from in the source mesh (surface.proto, TopologyPart). */
export interface PatchOrigins {
  /** Three per patch: corners of the source triangle. */
  readonly corners: Uint32Array;
  /** Nine per patch: for its corners 0, 1, 2 the barycentrics in that triangle. */
  readonly barycentrics: Float64Array;
}

/** Corners of all patches before any deformation, as x y z each, relative to `origin` (world units). */
export interface RestCorners {
  readonly origin: readonly [number, number, number];
  /** Nine per patch. */
  readonly corners: Float32Array;
}

/** What the surface asks for only when a look needs it. */
export interface PatchSource {
  origins(topologyId: string): Promise<PatchOrigins>;
  restCorners(): Promise<RestCorners>;
  /** Knot box of a world point at rest: a number per box, or -1 outside the frame. */
  boxOf(x: number, y: number, z: number): number;
}
