// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes triangles as binary PLY.
import { writeFileSync } from 'node:fs';
import type { Triangles } from './evaluate_patches.js';

export function writePly(path: string, { points, triangles }: Triangles): void {
  const header = Buffer.from(['ply', 'format binary_little_endian 1.0', `element vertex ${points.length}`,
    ...['x', 'y', 'z'].map((name) => `property float ${name}`), `element face ${triangles.length / 3}`,
    'property list uchar int vertex_indices', 'end_header', ''].join('\n'));
  const vertices = Buffer.from(Float32Array.from(points.flat()).buffer);
  const faces = Buffer.alloc(13 * triangles.length / 3);
  for (let i = 0; i < triangles.length; ++i) {
    const begin = 13 * Math.floor(i / 3);
    faces[begin] = 3;
    faces.writeInt32LE(triangles[i]!, begin + 1 + 4 * (i % 3));
  }
  writeFileSync(path, Buffer.concat([header, vertices, faces]));
}
