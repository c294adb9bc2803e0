// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ServerInfo } from 'latticed/v1/server_pb';
import { Code } from '@connectrpc/connect';
import { DecodePool } from '../decode/decode_pool';
import { SurfaceMesh } from '../surface/surface_mesh';
import { DeformSocket } from '../wire/deform_socket';
import type { LatticedServer } from '../wire/latticed_server';
import { MeshDownloads } from '../wire/mesh_downloads';
import { ServerError } from '../wire/server_error';
import { WatchStream } from '../wire/watch_stream';
import { inWords, tokenWanted } from '../wire/words';
import { LiveSession } from './live_session';
import { followPage } from './scene_connection';
import type { SessionStatus } from './scene_session';
import { ServerPatches } from './server_patches';
import type { SessionOptions } from './session_stream';

const ATTEMPTS = 4;
const FIRST_WAIT_MS = 500; // each wait is twice the one before
const SILENCE_MS = 15_000; // then a call counts as lost

let pool: Promise<DecodePool> | undefined;  // one for the page, since workers are costly

function poolOfPage(): Promise<DecodePool> {
  pool ??= DecodePool.inBrowser().catch((error: unknown) => {
    pool = undefined;  // the next call tries again
    throw error;
  });
  return pool;
}

async function infoOf(server: LatticedServer): Promise<ServerInfo> {
  const { token } = server;
  const info = await server.server.getServerInfo({}, { timeoutMs: SILENCE_MS });
  if (info.role === 'read' && server.token === token) server.mayEdit = false;
  return info;
}

/**
 * What a session needs first. What fails in passing, as where a server is short of connections, is tried again; without a
 * token that is valid, one is waited for.
 */
async function prepared(server: LatticedServer, onStatus: (status: SessionStatus) => void): Promise<[ServerInfo, DecodePool]> {
  let attempt = 1;
  for (;;) {
    try {
      return await Promise.all([infoOf(server), poolOfPage()]);
    } catch (error) {
      const { code, isPassing } = ServerError.fromConnect(error);
      if (code === Code.Unauthenticated) {
        onStatus({ state: 'token', text: tokenWanted(server.token !== undefined) });
        await tokenOf(server);
        continue;
      }
      if (attempt === ATTEMPTS || !isPassing) {
        onStatus({ state: 'failed', text: inWords(error) });
        throw new Error(inWords(error));
      }
      onStatus({ state: 'retrying', text: `${inWords(error)} Trying again …` });
      await new Promise((resolve) => setTimeout(resolve, FIRST_WAIT_MS * 2 ** (attempt++ - 1)));
    }
  }
}

/** Waits for another token. */
function tokenOf(server: LatticedServer): Promise<void> {
  return new Promise((resolve) => {
    const end = server.onToken(() => {
      end();
      resolve();
    });
  });
}

/**
 * Opens a scene of the server.
 *
 * @param onStatus Called for attempts before the session exists, and for every status afterwards.
 *
 * Resolves when its lattice has arrived. Rejects with an Error in words if the scene cannot be opened.
 */
export async function openSession(
  server: LatticedServer, sceneId: string, options: SessionOptions, onStatus: (status: SessionStatus) => void,
): Promise<LiveSession> {
  onStatus({ state: 'connecting', text: 'Connecting …' });
  const [info, decoders] = await prepared(server, onStatus);
  const session: LiveSession = new LiveSession(sceneId, {
    server,
    info,
    streams: [
      (open, handlers) => new DeformSocket(server.origin, server.token, open, handlers),
      (open, handlers) => new WatchStream(server, open, handlers),
    ],
    pool: decoders,
    surface: new SurfaceMesh(new ServerPatches(server, sceneId, () => session.lattice, () => session.lattices)),
    downloads: new MeshDownloads(server.meshes),
    wakes: followPage,
    ...options,
  });
  session.on('status', onStatus);
  try {
    await session.ready;
  } catch (error) {
    session.close();
    throw error;
  }
  return session;
}
