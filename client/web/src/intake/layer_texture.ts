// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The layers of a mesh as one texture. Pictures are scaled to one size; a colour fills its layer.
import { DataArrayTexture, LinearFilter, LinearMipmapLinearFilter, RepeatWrapping, SRGBColorSpace } from 'three';
import type { Layer } from './corner_layers';

const MOST_TEXELS = 2 ** 25; // of all layers: 128 MiB, plus a third for the mipmaps
const ANISOTROPY = 4;

export async function layerTexture(layers: readonly Layer[]): Promise<DataArrayTexture> {
  const pictures = await Promise.all(layers.map(({ picture }) => picture && createImageBitmap(picture)));
  const most = (side: 'width' | 'height'): number => Math.max(1, ...pictures.map((picture) => picture?.[side] ?? 1));
  const shrink = Math.min(1, Math.sqrt(MOST_TEXELS / (most('width') * most('height') * layers.length)));
  const [width, height] = [most('width'), most('height')].map((side) => Math.max(1, Math.floor(side * shrink)));
  const canvas = Object.assign(document.createElement('canvas'), { width, height });
  const context = canvas.getContext('2d', { willReadFrequently: true })!;
  const texels = new Uint8Array(4 * width * height * layers.length);
  layers.forEach(({ colour = 'white' }, i) => {
    context.globalCompositeOperation = 'source-over';
    context.fillStyle = colour;
    context.fillRect(0, 0, width, height);
    context.globalCompositeOperation = 'multiply';
    if (pictures[i] !== undefined) context.drawImage(pictures[i], 0, 0, width, height);
    pictures[i]?.close();
    texels.set(context.getImageData(0, 0, width, height).data, 4 * width * height * i);
  });
  const texture = new DataArrayTexture(texels, width, height, layers.length);
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = ANISOTROPY;
  texture.needsUpdate = true;
  return texture;
}

/** 16 x 16 fields. Their hue changes with u, their brightness with v. */
export function uvGrid(): HTMLCanvasElement {
  const [fields, pixels] = [16, 32];
  const canvas = Object.assign(document.createElement('canvas'), { width: fields * pixels, height: fields * pixels });
  const context = canvas.getContext('2d')!;
  for (let i = 0; i < fields; ++i) {
    for (let j = 0; j < fields; ++j) {
      const light = 48 + (30 * (j + 1)) / fields - ((i + j) % 2) * 12;
      context.fillStyle = `hsl(${(360 * i) / fields} 45% ${light}%)`;
      context.fillRect(i * pixels, j * pixels, pixels, pixels);
    }
  }
  return canvas;
}
