// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a person does on the viewer's page.
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed

/** Drops files, of text or bytes, onto the page. */
export function dropFiles(page: Page, files: readonly (readonly [name: string, content: string | Buffer])[]): Promise<void> {
  return page.evaluate(
    (list) => {
      const dataTransfer = new DataTransfer();
      for (const [name, base64] of list) {
        const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
        dataTransfer.items.add(new File([bytes], name));
      }
      window.dispatchEvent(new DragEvent('drop', { dataTransfer, cancelable: true }));
    },
    files.map(([name, content]) => [name, Buffer.from(content).toString('base64')] as const),
  );
}

/** Takes the lattice that the dialog offers, and waits until the scene is shown. */
export async function createScene(page: Page): Promise<void> {
  const before = await page.evaluate(() => window.latticed.scene?.session.sceneId);
  await page.getByText(/vertices, .* faces/).waitFor();
  await page.getByRole('button', { name: 'Create scene' }).click();
  await page.waitForFunction((id) => {
    const { scene } = window.latticed;
    return scene !== undefined && scene.session.sceneId !== id && scene.session.surface.patchCount > 0;
  }, before);
}

/** The colour of the page's view where a point of the world is, 0 to 255. */
export function colourAt(page: Page, x: number, y: number, z: number): Promise<[number, number, number]> {
  return page.evaluate(
    (point) => {
      const { viewport } = window.latticed;
      const [px, py] = viewport.project(point)!;
      viewport.renderer.render(viewport.scene, viewport.rig.camera);
      const gl = viewport.renderer.getContext();
      const ratio = viewport.renderer.getPixelRatio();
      const pixel = new Uint8Array(4);
      gl.readPixels(px * ratio, gl.drawingBufferHeight - 1 - py * ratio, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      return [pixel[0], pixel[1], pixel[2]] as [number, number, number];
    },
    [x, y, z] as const,
  );
}
