// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** How the surface is drawn. */
export interface SurfaceLook {
  /** boxes: a colour per knot box; displacement: a heat map of the distance from the rest shape. */
  readonly colouring?: 'plain' | 'boxes' | 'displacement' | 'texture';
  readonly wireframe?: boolean;
  readonly patchEdges?: boolean;
  /** The rest shape as a ghost. */
  readonly ghost?: boolean;
  readonly colour?: number;
}

/** What is known of patches besides their points: their shape at rest, texture coordinates. */
export type PatchFacts = 'rest' | 'uvs';
