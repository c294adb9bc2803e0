// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import type { Client } from '@connectrpc/connect';
import { MeshHeaderSchema, type MeshHeader, type MeshService } from 'latticed/v1/mesh_pb';

type MeshClient = Client<typeof MeshService>;

/** A mesh as it was uploaded. */
interface DownloadedMesh {
  readonly header: MeshHeader;
  readonly content: Blob;
}

interface Download {
  readonly mesh: Promise<DownloadedMesh>;
  readonly abort: AbortController;
  /** Those who have not given up. */
  waiting: number;
}

/** Meshes on their way from the server. Who asks for one that is under way already waits for the same bytes. */
export class MeshDownloads {
  private readonly underWay = new Map<string, Download>();

  constructor(private readonly meshes: MeshClient) {}

  /** A mesh as it was uploaded, and what it is. Rejects with the signal's reason; nothing is sent that nobody waits for. */
  async get(id: string, signal?: AbortSignal): Promise<DownloadedMesh> {
    signal?.throwIfAborted();
    const download = this.underWay.get(id) ?? this.begin(id);
    ++download.waiting;
    return new Promise((resolve, reject) => {
      const giveUp = (): void => {
        reject(signal!.reason);
        if (--download.waiting === 0) this.end(id, download);
      };
      signal?.addEventListener('abort', giveUp);
      void download.mesh.then(resolve, reject).finally(() => signal?.removeEventListener('abort', giveUp));
    });
  }

  private begin(id: string): Download {
    const abort = new AbortController();
    const download: Download = { mesh: downloadMesh(this.meshes, id, abort.signal), abort, waiting: 0 };
    this.underWay.set(id, download);
    const forget = (): void => this.forget(id, download);
    download.mesh.then(forget, forget);
    return download;
  }

  private end(id: string, download: Download): void {
    this.forget(id, download); // who comes now begins anew
    download.abort.abort();
  }

  private forget(id: string, download: Download): void {
    if (this.underWay.get(id) === download) this.underWay.delete(id);
  }
}

const PIECE_BYTES = 8 << 20;  // the page holds one piece in memory; the browser may keep the others on disk

/** Downloads one mesh. */
async function downloadMesh(meshes: MeshClient, mesh: string, signal: AbortSignal): Promise<DownloadedMesh> {
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
