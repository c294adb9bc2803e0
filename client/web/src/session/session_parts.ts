// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { ServerInfo } from 'latticed/v1/server_pb';
import type { DecodePool } from '../decode/decode_pool';
import type { SurfaceMesh } from '../surface/surface_mesh';
import type { LatticedServer } from '../wire/latticed_server';
import type { OpenStream } from '../wire/scene_stream';
import type { Wakeable } from './page_wakes';
import type { BackOff } from './scene_connection';
import type { SceneKeeper } from './store/scene_keeper';
import type { ViewRequest } from './scene_session';

/** What a session works with. */
export interface SessionParts {
  readonly server: LatticedServer;
  readonly info: ServerInfo;
  readonly streams: readonly OpenStream[];
  readonly pool: DecodePool;
  readonly surface: SurfaceMesh;
  readonly keeper: SceneKeeper;
  readonly name?: string;
  readonly colour?: number;
  readonly view?: ViewRequest;
  readonly backOff?: BackOff;
  /** Wakes the connection when the page wakes, until what it returns is called. */
  readonly wakes?: (connection: Wakeable) => () => void;
}
