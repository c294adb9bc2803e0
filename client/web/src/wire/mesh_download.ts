// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import type { Client } from '@connectrpc/connect';
import { MeshHeaderSchema, type MeshHeader, type MeshService } from 'latticed/v1/mesh_pb';

/** A mesh as it was uploaded. */
export interface DownloadedMesh {
  readonly header: MeshHeader;
  readonly content: Blob;
}

const PIECE_BYTES = 8 << 20;  // the page holds one piece in memory; the browser may keep the others on disk

export async function downloadMesh(meshes: Client<typeof MeshService>, mesh: string, signal: AbortSignal): Promise<DownloadedMesh> {
  let header = create(MeshHeaderSchema);
  const pieces: Blob[] = [];
  let parts: Uint8Array<ArrayBuffer>[] = [];
  let bytes = 0;
  for await (const { message } of meshes.downloadMesh({ mesh }, { signal })) {
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
