// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A sheet of 16 quads over -1 to 1. Its texture coordinates go from 0 to 1, u to the right and v up.

const vertices = Array.from({ length: 5 }, (_, j) => Array.from({ length: 5 }, (__, i) => [i / 4, j / 4] as const)).flat();
const quads = Array.from({ length: 16 }, (_, q) => {
  const at = Math.floor(q / 4) * 5 + (q % 4);
  return [at, at + 1, at + 6, at + 5];
});

/** @param material The line before a quad. Quads are numbered in rows from below. */
export function sheetObj(material: (quad: number) => string = () => ''): string {
  const lines = vertices.flatMap(([u, v]) => [`v ${2 * u - 1} ${2 * v - 1} 0`, `vt ${u} ${v}`]);
  const faces = quads.flatMap((quad, q) => [material(q), `f ${quad.map((i) => `${i + 1}/${i + 1}`).join(' ')}`]);
  return ['mtllib sheet.mtl', ...lines, ...faces].join('\n');
}

/** The sheet without texture coordinates. */
export function plainSheetObj(): string {
  return sheetObj().replace(/^vt.*\n/gm, '').replace(/\/\d+/g, '');
}

export function sheetPly(): string {
  const rows = vertices.map(([u, v]) => `${2 * u - 1} ${2 * v - 1} 0 ${u} ${v}`);
  const faces = quads.map((quad) => `4 ${quad.join(' ')}`);
  return `ply\nformat ascii 1.0\ncomment TextureFile squares.png\nelement vertex 25\nproperty float x\nproperty float y\n` +
    `property float z\nproperty float s\nproperty float t\nelement face 16\nproperty list uchar int vertex_indices\n` +
    `end_header\n${[...rows, ...faces].join('\n')}\n`;
}
