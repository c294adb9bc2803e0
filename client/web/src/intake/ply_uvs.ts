// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Texture coordinates of a PLY file by its two conventions: of vertices (s t, u v, texture_u texture_v, texture_s
// texture_t), or of the corners of every face, the list texcoord, with texnumber for which picture. The pictures' names
// are comments: "comment TextureFile NAME".
import { PlyBody, readPlyHeader, type PlyElement } from './ply_body';

export interface PlyCorners {
  /** u v picture of every corner of the faces, in the file's order; v counts upwards, as in the file. */
  readonly corners: Float32Array;
  /** Names of pictures; may be empty. */
  readonly pictures: readonly string[];
}

const U_NAMES = ['s', 'u', 'texture_u', 'texture_s'];
const V_NAMES = ['t', 'v', 'texture_v', 'texture_t'];
const INDEX_LISTS = ['vertex_indices', 'vertex_index'];

/** Undefined without texture coordinates; throws an Error in words where the file cannot be read for them. */
export function plyCorners(bytes: Uint8Array): PlyCorners | undefined {
  const { elements, comments, ...form } = readPlyHeader(bytes);
  const body = new PlyBody(bytes, form);
  const corners: number[] = [];
  let uvs: number[] | undefined;
  let any = false;
  for (const element of elements) {
    if (element.name === 'tristrips') throw new Error('Textures of PLY files with triangle strips are not shown.');
    if (element.name === 'vertex') uvs = vertexUvs(element, body);
    else if (element.name === 'face') any = faceCorners(element, body, uvs, corners);
    else for (let i = 0; i < element.count; ++i) body.record(element);
  }
  const pictures = comments.flatMap((comment) => /^\s*TextureFile\s+(.*?)\s*$/i.exec(comment)?.[1] ?? []);
  return any ? { corners: Float32Array.from(corners), pictures } : undefined;
}

function vertexUvs(element: PlyElement, body: PlyBody): number[] | undefined {
  const column = (names: readonly string[]): number =>
    element.properties.findIndex(({ name, countType }) => countType === undefined && names.includes(name));
  const [u, v] = [column(U_NAMES), column(V_NAMES)];
  const uvs: number[] = [];
  for (let i = 0; i < element.count; ++i) {
    const record = body.record(element);
    if (u >= 0 && v >= 0) uvs.push(record[u][0], record[v][0]);
  }
  return u >= 0 && v >= 0 ? uvs : undefined;
}

/** Appends the corners of all faces; says whether there are texture coordinates. */
function faceCorners(element: PlyElement, body: PlyBody, uvs: number[] | undefined, corners: number[]): boolean {
  const column = (...names: string[]): number => element.properties.findIndex(({ name }) => names.includes(name));
  const [indices, own, number] = [column(...INDEX_LISTS), column('texcoord'), column('texnumber')];
  for (let i = 0; i < element.count; ++i) {
    const record = body.record(element);
    const ofFace = own >= 0 ? record[own] : [];
    const picture = number >= 0 ? Math.max(record[number][0], 0) : 0;
    record[indices].forEach((vertex, corner) => {
      const at = ofFace.length > 0 ? [ofFace, 2 * corner] as const : [uvs ?? [], 2 * vertex] as const;
      corners.push(at[0][at[1]] ?? 0, at[0][at[1] + 1] ?? 0, picture);
    });
  }
  return uvs !== undefined || own >= 0;
}
