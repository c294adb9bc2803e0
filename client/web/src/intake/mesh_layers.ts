// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The base colours of a mesh, from its file and from the pictures and the MTL file that were dropped beside it. Without
// any, a grid shows the texture coordinates.
import { findByName, missing, type Layer, type MeshLayers } from './corner_layers';
import { glbJson } from './glb_json';
import { glbLayers } from './glb_uvs';
import { fileKind, type MeshFile } from './mesh_file';
import { readMtl, type Material } from './mtl';
import { objCorners } from './obj_uvs';
import { plyCorners } from './ply_uvs';

/**
 * @param companions Pictures, and an MTL file.
 * @param grid Used in place of a missing picture.
 *
 * Throws an Error in words if the file has no texture coordinates, or if they are not read from its format.
 */
export async function meshLayers(file: MeshFile, companions: readonly File[], grid: ImageBitmapSource): Promise<MeshLayers> {
  const pictures = companions.filter(({ name }) => fileKind(name) === 'picture');
  switch (file.format) {
    case 'obj':
      return objLayers(file, pictures, companions.find(({ name }) => fileKind(name) === 'materials'), grid);
    case 'ply':
      return plyLayers(file, pictures, grid);
    case 'glb':
      return ofGlb(file, pictures, grid);
    case 'stl':
      throw new Error('STL files have no texture coordinates.');
    case 'drc':
      throw new Error('Textures are shown of OBJ, PLY and GLB files, not of Draco files.');
  }
}

/** Whether a mesh is first shown in its colours: files came with it, even in vain, or pictures are inside. */
export async function hasColours(file: MeshFile, companions: readonly File[]): Promise<boolean> {
  if (companions.length > 0) return true;
  return file.format === 'glb' && (await glbJson(file.content)).includes('"baseColorTexture"');
}

async function objLayers(file: MeshFile, pictures: File[], mtl: File | undefined, grid: ImageBitmapSource): Promise<MeshLayers> {
  const { corners, materials, hasUvs } = objCorners(await file.content.text());
  const described = readMtl((await mtl?.text()) ?? '');
  if (!hasUvs && described.size === 0) throw new Error(`${file.name} has no texture coordinates.`);
  const namesPictures = [...described.values()].some(({ picture }) => picture !== undefined);
  const notes: string[] = [];
  const layers = materials.map((name): Layer => {
    const { picture, colour }: Material = described.get(name) ?? {};
    const unnamed = namesPictures ? undefined : pictureOf(name, pictures);
    const found = picture === undefined ? unnamed : findByName(pictures, picture);
    if (found !== undefined) return { picture: found };
    if (picture !== undefined) notes.push(missing(file.name, picture));
    return colour === undefined ? { picture: grid } : { colour };
  });
  return { corners: downwards(corners), layers, notes };
}

/** If no MTL file names pictures: the picture that is named like the material, else the only picture. */
function pictureOf(material: string, pictures: readonly File[]): File | undefined {
  const named = pictures.find(({ name }) => name.replace(/\.[^.]*$/, '').toLowerCase() === material.toLowerCase());
  return named ?? (pictures.length === 1 ? pictures[0] : undefined);
}

async function plyLayers(file: MeshFile, pictures: File[], grid: ImageBitmapSource): Promise<MeshLayers> {
  const read = plyCorners(new Uint8Array(await file.content.arrayBuffer()));
  if (read === undefined) throw new Error(`${file.name} has no texture coordinates.`);
  const notes: string[] = [];
  const named = read.pictures.length > 0 ? read.pictures : [''];
  const layers = named.map((name): Layer => {
    const found = findByName(pictures, name) ?? (named.length === 1 ? pictures[0] : undefined);
    if (found === undefined && name !== '') notes.push(missing(file.name, name));
    return { picture: found ?? grid };
  });
  return { corners: downwards(read.corners), layers, notes };
}

/** A dropped picture that the file does not name replaces all pictures of the file. */
async function ofGlb(file: MeshFile, pictures: File[], grid: ImageBitmapSource): Promise<MeshLayers> {
  const { hasUvs, takesPictures, ...read } = await glbLayers(file.name, await file.content.arrayBuffer(), pictures);
  const pictured = read.layers.some((layer) => layer.picture !== undefined);
  const [picture] = takesPictures ? [] : pictures;
  if (!hasUvs && picture !== undefined) throw new Error(`${file.name} has no texture coordinates.`);
  if (picture !== undefined) return { ...read, notes: [], layers: read.layers.map(() => ({ picture })) };
  return pictured || !hasUvs ? read : { ...read, layers: read.layers.map(() => ({ picture: grid })) };
}

/** Turns v from upwards to downwards, in place. */
function downwards(corners: Float32Array): Float32Array {
  for (let i = 1; i < corners.length; i += 3) corners[i] = 1 - corners[i];
  return corners;
}
