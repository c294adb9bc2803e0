// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { MessageInitShape } from '@bufbuild/protobuf';
import type { AppendUploadRequestSchema, Mesh, MeshHeaderSchema } from 'latticed/v1/mesh_pb';
import { LONG_CALL_MS } from './deadlines';
import { randomId } from './ids';
import type { LatticedServer } from './latticed_server';
import { ServerError } from './server_error';

export type MeshHeaderInit = MessageInitShape<typeof MeshHeaderSchema>;

export interface UploadOptions {
  /** Called after every part, in bytes. */
  readonly onProgress?: (sent: number, all: number) => void;
  readonly signal?: AbortSignal;
}

const PART_BYTES = 768 * 1024;  // the most that AppendUpload takes

/**
 * Uploads a file in parts and returns its mesh. A part whose answer was lost is sent once more. One part of the file is
 * in memory at a time. Rejects with a ServerError.
 *
 * @param header Name, format and so on; total_bytes is filled in.
 */
export async function uploadMesh(
  server: LatticedServer, header: MeshHeaderInit, content: Blob, options: UploadOptions = {},
): Promise<Mesh> {
  const headers = { 'latticed-upload': randomId() };  // the parts of an upload go to one server
  const call = { signal: options.signal, timeoutMs: LONG_CALL_MS, headers };
  try {
    const { uploadId } = await server.meshes.beginUpload({ header: { ...header, totalBytes: BigInt(content.size) } }, call);
    for (let offset = 0; offset < content.size;) {
      const data = new Uint8Array(await content.slice(offset, offset + PART_BYTES).arrayBuffer());
      offset = await append(server, { uploadId, offset: BigInt(offset), data }, call);
      options.onProgress?.(offset, content.size);
    }
    return await server.meshes.finishUpload({ uploadId }, call);
  } catch (error) {
    throw ServerError.fromConnect(error);
  }
}

/** Sends one part, and once more if its answer was lost. Returns how many bytes the server has. */
async function append(
  server: LatticedServer, part: MessageInitShape<typeof AppendUploadRequestSchema>, call: { signal?: AbortSignal | undefined },
): Promise<number> {
  const send = () => server.meshes.appendUpload(part, call);
  const { committed } = await send().catch((error: unknown) => {
    if (!ServerError.fromConnect(error).isPassing || call.signal?.aborted) throw error;
    return send();
  });
  return Number(committed);
}
