// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { MessageInitShape } from '@bufbuild/protobuf';
import type { Mesh, MeshHeaderSchema } from 'latticed/v1/mesh_pb';
import type { LatticedServer } from './latticed_server';
import { ServerError } from './server_error';

export type MeshHeaderInit = MessageInitShape<typeof MeshHeaderSchema>;

export interface UploadOptions {
  /** Told after every part, in bytes. */
  readonly onProgress?: (sent: number, all: number) => void;
  readonly signal?: AbortSignal;
}

const PART_BYTES = 768 * 1024;  // the most that AppendUpload takes

/**
 * Uploads a file in parts that are resumed where one was lost; returns its mesh. Rejects with a ServerError.
 *
 * @param header Name, format and so on; total_bytes is filled in.
 */
export async function uploadMesh(
  server: LatticedServer, header: MeshHeaderInit, bytes: Uint8Array, options: UploadOptions = {},
): Promise<Mesh> {
  const call = { ...(options.signal && { signal: options.signal }) };
  try {
    const { uploadId } = await server.meshes.beginUpload({ header: { ...header, totalBytes: BigInt(bytes.length) } }, call);
    for (let offset = 0; offset < bytes.length;) {
      offset = await append(server, uploadId, bytes, offset, call);
      options.onProgress?.(offset, bytes.length);
    }
    return await server.meshes.finishUpload({ uploadId }, call);
  } catch (error) {
    throw ServerError.fromConnect(error);
  }
}

/** Sends one part, twice where its answer was lost; returns how many bytes the server has. */
async function append(
  server: LatticedServer, uploadId: string, bytes: Uint8Array, offset: number, call: { signal?: AbortSignal },
): Promise<number> {
  const part = { uploadId, offset: BigInt(offset), data: bytes.subarray(offset, offset + PART_BYTES) as Uint8Array<ArrayBuffer> };
  try {
    return Number((await server.meshes.appendUpload(part, call)).committed);
  } catch (error) {
    if (!ServerError.fromConnect(error).isPassing || call.signal?.aborted) throw error;
    return Number((await server.meshes.appendUpload(part, call)).committed);
  }
}
