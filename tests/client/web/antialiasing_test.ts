// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { wantsAntialiasing } from '@src/viewport/antialiasing';

const UNMASKED = 0x9246;
const RENDERER = 0x1f01;

/** What a browser on a screen of this pixel ratio answers, whose WebGL has these names; counts contexts that stay. */
function asked(devicePixelRatio: number, names: Record<number, string> | null): { wants: boolean; left: number } {
  let left = 0;
  const context = names && {
    RENDERER,
    getParameter: (name: number) => names[name] ?? null,
    getExtension: (name: string) =>
      name === 'WEBGL_lose_context' ? { loseContext: () => --left } : UNMASKED in names ? { UNMASKED_RENDERER_WEBGL: UNMASKED } : null,
  };
  const getContext = (): typeof context => {
    if (context) ++left;
    return context;
  };
  Object.assign(globalThis, { window: { devicePixelRatio }, document: { createElement: () => ({ getContext }) } });
  try {
    return { wants: wantsAntialiasing(), left };
  } finally {
    for (const name of ['window', 'document']) delete (globalThis as Record<string, unknown>)[name];
  }
}

test('edges are drawn smooth by a graphics processor on a coarse screen, and not where that takes a program or shows nothing', () => {
  const card = 'ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)';
  const program = 'ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)';

  assert.deepEqual(asked(1, { [UNMASKED]: card }), { wants: true, left: 0 });
  assert.deepEqual(asked(1.5, { [RENDERER]: 'Radeon R9 200 Series, or similar' }), { wants: true, left: 0 });
  assert.equal(asked(2, { [UNMASKED]: card }).wants, false);
  assert.deepEqual(asked(1, { [UNMASKED]: program, [RENDERER]: 'WebKit WebGL' }), { wants: false, left: 0 });
  assert.equal(asked(1, { [RENDERER]: 'llvmpipe (LLVM 15.0.6, 256 bits)' }).wants, false);
  assert.equal(asked(1, { [UNMASKED]: 'ANGLE (Microsoft, Microsoft Basic Render Driver Direct3D11)' }).wants, false);
  assert.equal(asked(1, null).wants, true); // three says that there is no WebGL
});
