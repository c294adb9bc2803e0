// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

/** A torus around z as an OBJ file: 2 * around * across triangles, radii 1 and 0.4. */
export function torusObj(around: number, across: number): string {
  const lines: string[] = [];
  for (let i = 0; i < around; ++i) {
    for (let j = 0; j < across; ++j) {
      const [a, b] = [(2 * Math.PI * i) / around, (2 * Math.PI * j) / across];
      const r = 1 + 0.4 * Math.cos(b);
      lines.push(`v ${r * Math.cos(a)} ${r * Math.sin(a)} ${0.4 * Math.sin(b)}`);
    }
  }
  const at = (i: number, j: number): number => 1 + (i % around) * across + (j % across);
  for (let i = 0; i < around; ++i) {
    for (let j = 0; j < across; ++j) {
      lines.push(`f ${at(i, j)} ${at(i + 1, j)} ${at(i + 1, j + 1)}`, `f ${at(i, j)} ${at(i + 1, j + 1)} ${at(i, j + 1)}`);
    }
  }
  return lines.join('\n');
}
