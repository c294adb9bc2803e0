// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Texture coordinates of a PLY file, in one of two conventions. They are properties of vertices (s t, u v, texture_u
// texture_v, texture_s texture_t), or the list texcoord of each face, with its picture in texnumber. Comments name the
// pictures: "comment TextureFile NAME". The server has read the file before, so it is well-formed.

const MOST_HEADER_BYTES = 1 << 20;

/** The DataView method that reads each type, and its size in bytes. */
const TYPES = {
  int8: ['getInt8', 1], char: ['getInt8', 1],
  uint8: ['getUint8', 1], uchar: ['getUint8', 1],
  int16: ['getInt16', 2], short: ['getInt16', 2],
  uint16: ['getUint16', 2], ushort: ['getUint16', 2],
  int32: ['getInt32', 4], int: ['getInt32', 4],
  uint32: ['getUint32', 4], uint: ['getUint32', 4],
  float32: ['getFloat32', 4], float: ['getFloat32', 4],
  float64: ['getFloat64', 8], double: ['getFloat64', 8],
} as const;
type PlyType = keyof typeof TYPES;

interface PlyElement {
  readonly name: string;
  readonly count: number;
  /** `countType` is the type of a list's length; absent for a single value. */
  readonly properties: { readonly name: string; readonly type: PlyType; readonly countType?: PlyType }[];
}

/** Reads the next record of an element: one array per property. */
type NextRecord = (element: PlyElement) => number[][];

interface PlyCorners {
  /** u v picture of every corner of the faces, in the file's order; v counts upwards, as in the file. */
  readonly corners: Float32Array;
  /** Names of pictures; may be empty. */
  readonly pictures: readonly string[];
}

const U_NAMES = ['s', 'u', 'texture_u', 'texture_s'];
const V_NAMES = ['t', 'v', 'texture_v', 'texture_t'];
const INDEX_LISTS = ['vertex_indices', 'vertex_index'];

/** Undefined without texture coordinates. Throws an Error in words if they cannot be read. */
export function plyCorners(bytes: Uint8Array): PlyCorners | undefined {
  const { elements, pictures, next } = openPly(bytes);
  const corners: number[] = [];
  let uvs: number[] | undefined;
  let any = false;
  for (const element of elements) {
    if (element.name === 'tristrips') throw new Error('Textures of PLY files with triangle strips are not shown.');
    if (element.name === 'vertex') uvs = vertexUvs(element, next);
    else if (element.name === 'face') any = faceCorners(element, next, uvs, corners);
    else for (let i = 0; i < element.count; ++i) next(element);
  }
  return any ? { corners: Float32Array.from(corners), pictures } : undefined;
}

function openPly(bytes: Uint8Array): { elements: readonly PlyElement[]; pictures: readonly string[]; next: NextRecord } {
  const begin = new TextDecoder('latin1').decode(bytes.subarray(0, MOST_HEADER_BYTES));
  const [header] = /^[^]*?^end_header[^\S\r\n]*(?:\r\n?|\n)/m.exec(begin) ?? [];
  if (header === undefined) throw new Error('The file ends before end_header.');
  const elements: PlyElement[] = [];
  const pictures: string[] = [];
  let encoding = 'ascii';
  for (const line of header.split(/\r\n?|\n/)) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === 'format') encoding = rest[0];
    else if (word === 'comment') pictures.push(...(/^\s*comment\s+TextureFile\s+(.*?)\s*$/i.exec(line)?.slice(1) ?? []));
    else if (word === 'element') elements.push({ name: rest[0], count: Number(rest[1]), properties: [] });
    else if (word === 'property') elements.at(-1)!.properties.push(property(rest));
  }
  const body = bytes.subarray(header.length);
  const nextNumber = encoding === 'ascii' ? asciiNumbers(body) : binaryNumbers(body, encoding === 'binary_little_endian');
  const next: NextRecord = ({ properties }) => properties.map(({ type, countType }) =>
    Array.from({ length: countType === undefined ? 1 : nextNumber(countType) }, () => nextNumber(type)));
  return { elements, pictures, next };
}

function property(words: readonly string[]): PlyElement['properties'][number] {
  const [countType, type, name] = words[0] === 'list' ? words.slice(1) : [undefined, ...words];
  return { name: name!, type: type as PlyType, countType: countType as PlyType | undefined };
}

function asciiNumbers(body: Uint8Array): () => number {
  const words = new TextDecoder().decode(body).matchAll(/\S+/g);
  return () => Number(words.next().value?.[0]);
}

function binaryNumbers(body: Uint8Array, little: boolean): (type: PlyType) => number {
  const view = new DataView(body.buffer, body.byteOffset, body.byteLength);
  let at = 0;
  return (type) => {
    const [read, size] = TYPES[type];
    at += size;
    return view[read](at - size, little);
  };
}

function vertexUvs(element: PlyElement, next: NextRecord): number[] | undefined {
  const column = (names: readonly string[]): number =>
    element.properties.findIndex(({ name, countType }) => countType === undefined && names.includes(name));
  const [u, v] = [column(U_NAMES), column(V_NAMES)];
  const uvs: number[] = [];
  for (let i = 0; i < element.count; ++i) {
    const record = next(element);
    if (u >= 0 && v >= 0) uvs.push(record[u][0], record[v][0]);
  }
  return u >= 0 && v >= 0 ? uvs : undefined;
}

/** Appends the corners of all faces. Returns whether there are texture coordinates. */
function faceCorners(element: PlyElement, next: NextRecord, uvs: number[] | undefined, corners: number[]): boolean {
  const column = (...names: string[]): number => element.properties.findIndex(({ name }) => names.includes(name));
  const [indices, own, number] = [column(...INDEX_LISTS), column('texcoord'), column('texnumber')];
  for (let i = 0; i < element.count; ++i) {
    const record = next(element);
    const ofFace = own >= 0 ? record[own] : [];
    const picture = number >= 0 ? Math.max(record[number][0], 0) : 0;
    record[indices].forEach((vertex, corner) => {
      const at = ofFace.length > 0 ? [ofFace, 2 * corner] as const : [uvs ?? [], 2 * vertex] as const;
      corners.push(at[0][at[1]] ?? 0, at[0][at[1] + 1] ?? 0, picture);
    });
  }
  return uvs !== undefined || own >= 0;
}
