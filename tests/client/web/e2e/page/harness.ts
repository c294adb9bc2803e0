// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
/** A page with only the store in which viewers keep scenes. */
import { IndexedSceneStore } from '@src/session/store/indexed_scene_store';

declare global {
  interface Window {
    store: IndexedSceneStore;
  }
}
window.store = IndexedSceneStore.ofPage();
