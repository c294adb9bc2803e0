// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pictures of four coloured squares, and the colours that a page shows.
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { GlbMaker } from '../support/glb';
import { colourAt } from '../support/viewer_page';

export const TEXTURED = { pbrMetallicRoughness: { baseColorTexture: { index: 0 } } };
export const ONE_NODE = { scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }] };

/** A PNG file of four squares: upper left, upper right, lower left, lower right. */
export async function paint(page: Page, ...colours: string[]): Promise<Buffer> {
  const png = await page.evaluate((four) => {
    const canvas = Object.assign(document.createElement('canvas'), { width: 64, height: 64 });
    const context = canvas.getContext('2d')!;
    four.forEach((colour, i) => {
      context.fillStyle = colour;
      context.fillRect(32 * (i % 2), 32 * Math.floor(i / 2), 32, 32);
    });
    return canvas.toDataURL('image/png').split(',')[1];
  }, colours);
  return Buffer.from(png, 'base64');
}

/** Looks straight at the sheet, without the cage, and waits until its texture is shown. */
export async function lookAtColours(of: Page): Promise<void> {
  await of.evaluate(() => {
    window.latticed.settings.set({ cage: false, gizmo: 'none' });
    window.latticed.viewport.rig.lookFrom([0, -1e-3, 1]);
    window.latticed.scene!.frameAll();
  });
  await of.waitForFunction(() => window.latticed.scene!.session.surface.isTextured);
}

/** The colour at a place of the sheet: red, green, blue or white. */
export async function nameAt(of: Page, x: number, y: number): Promise<string> {
  const [r, g, b] = await colourAt(of, [x, y, 0]);
  const most = Math.max(r, g, b);
  const strong = [r > most / 2, g > most / 2, b > most / 2].join();
  const names = { 'true,false,false': 'red', 'false,true,false': 'green', 'false,false,true': 'blue', 'true,true,true': 'white' };
  return names[strong as keyof typeof names] ?? `${[r, g, b]}`;
}

/** The colours of the four quarters of a square of side 2 around (x, y). */
export async function quarters(of: Page, x = 0, y = 0): Promise<string> {
  const names: string[] = [];
  for (const [dx, dy] of [[-0.5, 0.5], [0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]) names.push(await nameAt(of, x + dx, y + dy));
  return names.join(' ');
}

/** A GLB file of the square with an embedded picture, and `unused` bytes that nothing uses. */
export function squareGlb(content: Buffer, unused = 0): Buffer {
  const glb = new GlbMaker();
  const primitives = [{ ...glb.square(), material: 0 }];
  const source = glb.image(content);
  if (unused > 0) glb.image(Buffer.alloc(unused));
  return glb.file({ ...ONE_NODE, meshes: [{ primitives }], materials: [TEXTURED], textures: [{ source }] });
}
