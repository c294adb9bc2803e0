// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploads an OBJ file in parts.
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { basename } from 'node:path';
import type { Mesh__Output } from './generated/latticed/v1/Mesh.js';
import { call, type Services } from './services.js';

const PART_BYTES = 768 * 1024;  // the most data bytes that one message may hold

export function upload({ meshes }: Services, path: string): Promise<Mesh__Output> {
  const bytes = readFileSync(path);
  return call((done) => {
    const stream = meshes.UploadMesh(done);
    stream.write({
      header: {
        name: basename(path),
        format: 'MESH_FORMAT_OBJ',
        totalBytes: bytes.length,
        sha256: createHash('sha256').update(bytes).digest('hex'),
      },
    });
    for (let begin = 0; begin < bytes.length; begin += PART_BYTES) {
      stream.write({ data: bytes.subarray(begin, begin + PART_BYTES) });
    }
    stream.end();
  });
}
