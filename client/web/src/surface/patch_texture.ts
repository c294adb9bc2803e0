// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { DataTexture, FloatType, NearestFilter, RGBAFormat, UnsignedByteType } from 'three';

/** Texels in a row of a texture that holds numbers per patch. The shader uses it too. */
export const PATCH_TEXTURE_WIDTH = 1024;

/** A float texture with `texels` texels of four numbers per patch, patch after patch. */
export function patchTexture(patches: number, texels: number, fill: (patch: number, out: Float32Array, at: number) => void): DataTexture {
  const height = Math.max(1, Math.ceil((patches * texels) / PATCH_TEXTURE_WIDTH));
  const data = new Float32Array(4 * PATCH_TEXTURE_WIDTH * height);
  for (let patch = 0; patch < patches; ++patch) fill(patch, data, 4 * texels * patch);
  return finished(new DataTexture(data, PATCH_TEXTURE_WIDTH, height, RGBAFormat, FloatType));
}

/** The (i0, i1, i2) of each point of a patch, one texel per point. */
export function patternTexture(points: Uint32Array): DataTexture {
  const count = points.length / 3;
  const data = new Uint8Array(4 * count);
  for (let i = 0; i < count; ++i) data.set(points.subarray(3 * i, 3 * i + 3), 4 * i);
  return finished(new DataTexture(data, count, 1, RGBAFormat, UnsignedByteType));
}

function finished(texture: DataTexture): DataTexture {
  texture.magFilter = texture.minFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}
