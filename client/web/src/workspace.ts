// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The parts of the page that the opener and the commands work on.
import type { Services } from './intake/services';
import type { MeshExtent } from './lattice/mesh_extent';
import type { SceneView } from './scene_view';
import type { LiveSession } from './session/live_session';
import type { SessionStatus } from './session/scene_session';
import type { Settings } from './state/settings';
import type { RecentScenes } from './state/recent_scenes';
import type { SceneFacts } from './state/units';
import type { Store } from './state/store';
import type { BusySign } from './ui/overlays/busy_sign';
import type { Toasts } from './ui/toasts';
import type { Viewport } from './viewport/viewport';

export interface Workspace {
  readonly settings: Store<Settings>;
  readonly viewport: Viewport;
  readonly toasts: Toasts;
  readonly busy: BusySign;
  readonly services: Services;
  readonly recent: RecentScenes;
  /** The open scene. */
  readonly scene: SceneView | undefined;
  /** Replaces the open scene. */
  show(session: LiveSession, facts: SceneFacts): void;
  /** Shows the open scene's facts, if they are known later. */
  setFacts(facts: SceneFacts): void;
  /** Tells about the open scene's lattice, and its mesh if that is known. */
  watchLattice(extent: MeshExtent | undefined): void;
  showStatus(status: SessionStatus): void;
}
