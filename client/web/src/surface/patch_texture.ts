// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { DataTexture, FloatType, NearestFilter, RGBAFormat } from 'three';

/** Texels in a row of a texture that holds numbers per patch. The shader uses it too. */
export const PATCH_TEXTURE_WIDTH = 1024;

/** A float texture with `texels` texels of four numbers per patch, patch after patch. */
export function patchTexture(patches: number, texels: number, fill: (patch: number, out: Float32Array, at: number) => void): DataTexture {
  const height = Math.max(1, Math.ceil((patches * texels) / PATCH_TEXTURE_WIDTH));
  const data = new Float32Array(4 * PATCH_TEXTURE_WIDTH * height);
  for (let patch = 0; patch < patches; ++patch) fill(patch, data, 4 * texels * patch);
  return finished(new DataTexture(data, PATCH_TEXTURE_WIDTH, height, RGBAFormat, FloatType));
}

function finished(texture: DataTexture): DataTexture {
  texture.magFilter = texture.minFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}
