// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploads by unary calls, which browsers can make: begin, append part after part, finish. A part whose answer was lost
// is sent again: what the server has already it ignores.
import { Code, ConnectError } from '@connectrpc/connect';
import type { Mesh } from 'latticed/v1/mesh_pb';
import { MeshFormat } from 'latticed/v1/mesh_pb';
import type { Vec3 } from '../lattice/vec';
import type { LatticedServer } from '../wire/latticed_server';
import type { MeshFile, MeshFormatName } from './mesh_file';
import type { UploadedMesh } from './services';

const PART_BYTES = 512 * 1024; // below the 768 KiB of a data field, and often enough for a progress bar
const ATTEMPTS = 4;

const FORMATS: Record<MeshFormatName, MeshFormat> = {
  obj: MeshFormat.OBJ,
  ply: MeshFormat.PLY,
  stl: MeshFormat.STL,
  glb: MeshFormat.GLB,
  drc: MeshFormat.DRACO,
};

export async function uploadMesh(
  server: Pick<LatticedServer, 'meshes'>,
  file: MeshFile,
  progress: (fraction: number) => void,
  signal?: AbortSignal,
): Promise<UploadedMesh> {
  const total = file.bytes.length;
  const header = { name: file.name, format: FORMATS[file.format], totalBytes: BigInt(total) };
  const { uploadId } = await server.meshes.beginUpload({ header }, { signal });
  let offset = 0;
  while (offset < total) {
    const data = file.bytes.subarray(offset, Math.min(offset + PART_BYTES, total));
    offset = await append(server, uploadId, offset, data, signal);
    progress(offset / total);
  }
  return describe(await server.meshes.finishUpload({ uploadId }, { signal }));
}

/** Returns how many bytes the server has afterwards. */
async function append(
  server: Pick<LatticedServer, 'meshes'>,
  uploadId: string,
  offset: number,
  data: Uint8Array<ArrayBuffer>,
  signal?: AbortSignal,
): Promise<number> {
  for (let attempt = 1; ; ++attempt) {
    try {
      const { committed } = await server.meshes.appendUpload({ uploadId, offset: BigInt(offset), data }, { signal });
      return Number(committed);
    } catch (error) {
      if (attempt === ATTEMPTS || ConnectError.from(error).code !== Code.Unavailable) throw error;
      await new Promise((resolve) => setTimeout(resolve, 250 * 2 ** attempt));
    }
  }
}

function describe(mesh: Mesh): UploadedMesh {
  const vector = (v?: { x: number; y: number; z: number }): Vec3 => [v?.x ?? 0, v?.y ?? 0, v?.z ?? 0];
  return {
    id: mesh.id,
    name: mesh.name,
    vertices: Number(mesh.vertices),
    faces: Number(mesh.faces),
    bounds: { min: vector(mesh.bounds?.min), max: vector(mesh.bounds?.max) },
    hasNormals: mesh.hasNormals,
  };
}
