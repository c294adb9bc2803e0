// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** Texture coordinates of every corner of an OBJ file's faces, u v each, in the file's order; undefined without any. */
export function objCornerUvs(text: string): Float32Array | undefined {
  const uvs: [number, number][] = [];
  const corners: number[] = [];
  for (const line of text.split('\n')) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === 'vt') uvs.push([Number(rest[0]), Number(rest[1] ?? 0)]);
    else if (word === 'f') for (const corner of rest) corners.push(...uvOfCorner(corner, uvs));
  }
  return uvs.length === 0 ? undefined : Float32Array.from(corners);
}

/** Of "vertex/uv/normal"; indices count from 1, negative ones from the end of what came before. */
function uvOfCorner(corner: string, uvs: readonly [number, number][]): readonly [number, number] {
  const index = Number(corner.split('/')[1] || 0);
  return uvs[index < 0 ? uvs.length + index : index - 1] ?? [0, 0];
}
