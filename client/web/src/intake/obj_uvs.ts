// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

export interface ObjCorners {
  /** u v material of every corner of the faces, in the file's order; v counts upwards, as in the file. */
  readonly corners: Float32Array;
  /** Names after usemtl; empty for faces before the first usemtl. */
  readonly materials: readonly string[];
  readonly hasUvs: boolean;
}

export function objCorners(text: string): ObjCorners {
  const uvs: [number, number][] = [];
  const corners: number[] = [];
  const materials: string[] = [];
  let material = 0;
  const named = (name: string): number => {
    const found = materials.indexOf(name);
    return found >= 0 ? found : materials.push(name) - 1;
  };
  for (const line of text.replace(/\\\r?\n/g, ' ').split(/\r\n?|\n/)) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === 'vt') uvs.push([Number(rest[0]), Number(rest[1] ?? 0)]);
    else if (word === 'usemtl') material = named(line.trim().slice('usemtl'.length).trim());
    else if (word === 'f') {
      if (materials.length === 0) material = named('');
      for (const corner of rest) corners.push(...uvOfCorner(corner, uvs), material);
    }
  }
  return { corners: Float32Array.from(corners), materials, hasUvs: uvs.length > 0 };
}

/** The uv of a corner "vertex/uv/normal". Indices count from 1; negative ones count from the end of the list so far. */
function uvOfCorner(corner: string, uvs: readonly [number, number][]): readonly [number, number] {
  const index = Number(corner.split('/')[1] || 0);
  return uvs[index < 0 ? uvs.length + index : index - 1] ?? [0, 0];
}
