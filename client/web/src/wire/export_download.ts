// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { Code } from '@connectrpc/connect';
import type { ViewRequest } from '../session/scene_session';
import type { LatticedServer } from './latticed_server';
import { ServerError } from './server_error';

/** A file that the server has written. */
export interface ExportedFile {
  readonly name: string;
  readonly blob: Blob;
  /** The largest distance between its triangles and the exact surface, in world units; 0: not told, without a tolerance. */
  readonly certifiedError: number;
}

/** The tessellated exact surface, or the uploaded vertices and faces, moved. */
export type ExportGeometry = 'exact' | 'original';

/** The fields of a view that an export uses, and what it writes. */
export interface ExportView extends Pick<Required<ViewRequest>, 'segments' | 'tolerance' | 'normals'> {
  readonly geometry: ExportGeometry;
}

/** The server's reasons, by HTTP status. */
const REASONS: Readonly<Record<number, string>> = { 401: 'UNAUTHENTICATED', 429: 'OUT_OF_MEMORY' };

/**
 * Fetches /export/<scene>.<format> with the view's segments, tolerance, normals and geometry, and with the token that a plain link could not
 * carry. The browser, not the page, keeps the bytes; large files go to disk. Rejects with a ServerError.
 *
 * @param onProgress Called after every part, in bytes.
 */
export async function downloadExport(
  server: LatticedServer, sceneId: string, format: string, { segments, tolerance, normals, geometry }: ExportView,
  onProgress: (received: number, all: number) => void, signal: AbortSignal,
): Promise<ExportedFile> {
  const headers = { 'latticed-scene': sceneId, ...(server.token && { authorization: `Bearer ${server.token}` }) };
  try {
    const query = new URLSearchParams({ segments: String(segments), ...(tolerance > 0 && { tolerance: String(tolerance) }), normals, geometry });
    const answer = await fetch(`${server.origin}/export/${sceneId}.${format}?${query}`, { headers, signal });
    if (!answer.ok) throw new ServerError(Code.Unknown, REASONS[answer.status] ?? 'EXPORT_FAILED', (await answer.text()).trim());
    const all = Number(answer.headers.get('content-length') ?? 0);
    const counted = answer.body!.pipeThrough(counter((received) => onProgress(received, all)));
    const type = answer.headers.get('content-type') ?? 'application/octet-stream';
    const blob = await new Response(counted, { headers: { 'content-type': type } }).blob();
    const certifiedError = Number(answer.headers.get('latticed-certified-error') ?? 0);
    return { name: fileName(answer) ?? `${sceneId}.${format}`, blob, certifiedError };
  } catch (error) {
    if (error instanceof ServerError) throw error;
    throw new ServerError(Code.Unavailable, '', '');  // fetch tells only that it failed
  }
}

function counter(received: (bytes: number) => void): TransformStream<Uint8Array<ArrayBuffer>, Uint8Array<ArrayBuffer>> {
  let bytes = 0;
  return new TransformStream({
    transform(part, controller) {
      received((bytes += part.length));
      controller.enqueue(part);
    },
  });
}

/** The escaped file name of RFC 6266. */
function fileName(answer: Response): string | undefined {
  const escaped = /filename\*=UTF-8''([^;]+)/.exec(answer.headers.get('content-disposition') ?? '')?.[1];
  return escaped && decodeURIComponent(escaped);
}
