// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
/** A page with only the store in which viewers keep scenes, and with the evaluation of patches. */
import { IndexedSceneStore } from '@src/session/store/indexed_scene_store';
import { comparePatches, type Comparison } from '../../support/compare_patches';

type DropFirst<F extends (...all: never[]) => unknown> = Parameters<F> extends [unknown, ...infer Rest] ? Rest : never;

declare global {
  interface Window {
    store: IndexedSceneStore;
    comparePatches(...of: DropFirst<typeof comparePatches>): Promise<Comparison>;
  }
}
window.store = IndexedSceneStore.ofPage();

let context: WebGL2RenderingContext | null | undefined;
window.comparePatches = (...of) => {
  context ??= document.createElement('canvas').getContext('webgl2');
  if (!context) throw new Error('no WebGL2');
  return comparePatches(context, ...of);
};
