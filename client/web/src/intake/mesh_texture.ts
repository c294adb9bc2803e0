// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The base colour of a mesh: the picture that was dropped with it, the one inside its file, or a grid that shows how its
// texture coordinates lie.
import { CanvasTexture, RepeatWrapping, SRGBColorSpace, type Texture } from 'three';
import { glbTexture } from './glb_uvs';
import type { MeshFile } from './mesh_file';
import { objCornerUvs } from './obj_uvs';

export interface MeshTexture {
  readonly texture: Texture;
  readonly cornerUvs: Float32Array;
}

/** Throws an Error in words where the file has no texture coordinates, or is of a format that is not read for them. */
export async function meshTexture(file: MeshFile, picture?: Blob): Promise<MeshTexture> {
  if (file.format !== 'obj' && file.format !== 'glb') throw new Error('Textures are shown of OBJ and GLB files.');
  const found =
    file.format === 'glb'
      ? await glbTexture(file.bytes)
      : { cornerUvs: objCornerUvs(new TextDecoder().decode(file.bytes)) };
  if (found?.cornerUvs === undefined) throw new Error(`${file.name} has no texture coordinates.`);
  // glTF counts v downwards, OBJ upwards.
  const flipY = file.format === 'obj';
  const own = 'texture' in found ? found.texture : undefined;
  const texture =
    picture === undefined ? (own ?? canvasTexture(checker(), flipY)) : canvasTexture(await drawn(picture), flipY);
  return { texture, cornerUvs: found.cornerUvs };
}

function canvasTexture(canvas: HTMLCanvasElement, flipY: boolean): Texture {
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.flipY = flipY;
  return texture;
}

async function drawn(picture: Blob): Promise<HTMLCanvasElement> {
  const bitmap = await createImageBitmap(picture);
  const canvas = Object.assign(document.createElement('canvas'), { width: bitmap.width, height: bitmap.height });
  canvas.getContext('2d')!.drawImage(bitmap, 0, 0);
  return canvas;
}

/** 16 x 16 fields whose hue goes with u and whose brightness goes with v. */
function checker(): HTMLCanvasElement {
  const [fields, pixels] = [16, 32];
  const canvas = Object.assign(document.createElement('canvas'), { width: fields * pixels, height: fields * pixels });
  const context = canvas.getContext('2d')!;
  for (let i = 0; i < fields; ++i) {
    for (let j = 0; j < fields; ++j) {
      const light = 78 - (30 * j) / fields - ((i + j) % 2) * 12;
      context.fillStyle = `hsl(${(360 * i) / fields} 45% ${light}%)`;
      context.fillRect(i * pixels, j * pixels, pixels, pixels);
    }
  }
  return canvas;
}
