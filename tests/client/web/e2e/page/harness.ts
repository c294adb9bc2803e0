// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
/** A page with only the store in which viewers keep companions, with the evaluation of patches, and with the decoders. */
import { CompanionStore } from '@src/intake/companion_store';
import { measureDecode } from './decode_meter';
import { comparePatches, type Comparison } from '../../support/compare_patches';

type DropFirst<F extends (...all: never[]) => unknown> = Parameters<F> extends [unknown, ...infer Rest] ? Rest : never;

declare global {
  interface Window {
    store: CompanionStore;
    comparePatches(...of: DropFirst<typeof comparePatches>): Promise<Comparison>;
    measureDecode: typeof measureDecode;
  }
}
window.store = CompanionStore.ofPage();
window.measureDecode = measureDecode;

let context: WebGL2RenderingContext | null | undefined;
window.comparePatches = (...of) => {
  context ??= document.createElement('canvas').getContext('webgl2');
  if (!context) throw new Error('no WebGL2');
  return comparePatches(context, ...of);
};
