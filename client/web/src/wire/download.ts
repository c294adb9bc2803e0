// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { MeshHeaderSchema, type MeshHeader } from 'latticed/v1/mesh_pb';
import type { LatticedServer } from './latticed_server';

/** The bytes of a mesh as they were uploaded, and what they are. */
export async function downloadMesh(
  server: LatticedServer, mesh: string, signal?: AbortSignal,
): Promise<{ header: MeshHeader; bytes: Uint8Array }> {
  let header = create(MeshHeaderSchema);
  let bytes = new Uint8Array();
  let filled = 0;
  for await (const { message } of server.meshes.downloadMesh({ mesh }, { ...(signal && { signal }) })) {
    if (message.case === 'header') {
      header = message.value;
      bytes = new Uint8Array(Number(header.totalBytes));
    } else if (message.case === 'data') {
      bytes.set(message.value, filled);
      filled += message.value.length;
    }
  }
  return { header, bytes };
}
