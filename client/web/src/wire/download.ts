// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { MeshHeaderSchema, type MeshHeader } from 'latticed/v1/mesh_pb';
import type { LatticedServer } from './latticed_server';

const PIECE_BYTES = 8 << 20;  // of a file the page has one piece in memory; whole ones the browser may keep on disk

/** A mesh as it was uploaded, and what it is. */
export async function downloadMesh(
  server: LatticedServer, mesh: string, signal?: AbortSignal,
): Promise<{ header: MeshHeader; content: Blob }> {
  let header = create(MeshHeaderSchema);
  const pieces: Blob[] = [];
  let parts: Uint8Array<ArrayBuffer>[] = [];
  let bytes = 0;
  for await (const { message } of server.meshes.downloadMesh({ mesh }, { ...(signal && { signal }) })) {
    if (message.case === 'header') header = message.value;
    if (message.case !== 'data') continue;
    parts.push(message.value as Uint8Array<ArrayBuffer>);
    bytes += message.value.length;
    if (bytes < PIECE_BYTES) continue;
    pieces.push(new Blob(parts));
    parts = [];
    bytes = 0;
  }
  return { header, content: new Blob([...pieces, ...parts]) };
}
