// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Box3, DataArrayTexture, Object3D } from 'three';

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

/** The deformed surface as three draws it: one geometry for all chunks, written in place. */
export interface Surface {
  /** World coordinates less `origin`, which is its position. */
  readonly object: Object3D;
  /** World bounds of what was received last. */
  readonly bounds: Box3;
  readonly patchCount: number;
  readonly triangleCount: number;
  /** World units that the end of the heat map's colours stands for: the largest displacement that is seen. */
  readonly displacementRange: number;
  /** Called when it looks otherwise without an update: what a look asked for has come. */
  onChanged?: () => void;
  /** Called when what a look asked for cannot be had: it is drawn without. Once for each cause until another look is chosen. */
  onFailed?: (what: PatchFacts, error: unknown) => void;
  setLook(look: SurfaceLook): void;
  /**
   * Base colours in layers, with u v layer for each corner of the mesh, v from the texture's first row on; without both:
   * none. The texture stays its owner's.
   */
  setTexture(texture: DataArrayTexture | undefined, corners?: Float32Array): void;
  dispose(): void;
}
