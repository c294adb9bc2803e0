// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { LatticedServer } from '../wire/latticed_server';
import type { SceneSession, SessionStatus, ViewRequest } from './scene_session';

export interface SessionOptions {
  /** This editor's name for other windows. */
  readonly name?: string;
  /** This editor's colour, 0xRRGGBB. */
  readonly colour?: number;
  readonly view?: ViewRequest;
  /** Told of attempts before the session exists. */
  readonly onStatus?: (status: SessionStatus) => void;
}

/**
 * Opens a scene that exists on the server, or that this browser can restore.
 *
 * Resolves when its lattice is here; rejects with an Error in words where there is no such scene.
 */
export declare function openSession(server: LatticedServer, sceneId: string, options?: SessionOptions): Promise<SceneSession>;
