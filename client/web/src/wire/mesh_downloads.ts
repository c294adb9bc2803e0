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

/** Fetches the mesh of a scene from its server. */
export class MeshDownloads {
  private static readonly PIECE_BYTES = 8 << 20;  // the page holds one piece in memory; the browser may keep the others on disk

  private readonly closed = new AbortController();
  private running: Promise<DownloadedMesh> | undefined;

  constructor(private readonly meshes: Client<typeof MeshService>) {}

  /** Callers at the same time share one download. Rejects after close(). */
  downloadMesh(mesh: string): Promise<DownloadedMesh> {
    return (this.running ??= this.download(mesh).finally(() => (this.running = undefined)));
  }

  close(): void {
    this.closed.abort();
  }

  private async download(mesh: string): Promise<DownloadedMesh> {
    let header = create(MeshHeaderSchema);
    const pieces: Blob[] = [];
    let parts: Uint8Array<ArrayBuffer>[] = [];
    let bytes = 0;
    for await (const { message } of this.meshes.downloadMesh({ mesh }, { signal: this.closed.signal })) {
      if (message.case === 'header') header = message.value;
      if (message.case !== 'data') continue;
      parts.push(message.value as Uint8Array<ArrayBuffer>);
      bytes += message.value.length;
      if (bytes < MeshDownloads.PIECE_BYTES) continue;
      pieces.push(new Blob(parts));
      parts = [];
      bytes = 0;
    }
    return { header, content: new Blob([...pieces, ...parts]) };
  }
}
