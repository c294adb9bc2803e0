// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
/** A page with nothing but the store that viewers keep scenes in. */
import { IndexedSceneStore } from '@src/session/store/indexed_scene_store';

declare global {
  interface Window {
    store: IndexedSceneStore;
  }
}
window.store = IndexedSceneStore.ofPage();
