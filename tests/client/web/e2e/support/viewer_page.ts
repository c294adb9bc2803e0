// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Actions of a person on the viewer's page, and what the page then shows.
import { readFileSync } from 'node:fs';
import type { Download, Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import { clampedUniformKnots, identityPoints, knotVectors } from '@src/lattice/identity';
import { Lattice } from '@src/lattice/lattice';
import type { Basis, Vec3 } from '@src/lattice/vec';

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

/** Waits until the dialog has the mesh. Until then its button may still take the focus. */
export function meshUploaded(page: Page): Promise<void> {
  return page.locator('dialog[open]').getByText(/vertices, .* faces/).waitFor(); // a dialog that closed leaves the page a moment later
}

/** Takes the lattice that the dialog offers, with z up, and waits until the scene is shown. */
export async function createScene(page: Page, up: 'y' | 'z' = 'z'): Promise<void> {
  const before = await page.evaluate(() => window.latticed.scene?.session.sceneId);
  await meshUploaded(page);
  const choice = page.getByRole('radiogroup', { name: 'Up' }).getByRole('radio', { name: up.toUpperCase() });
  if (await choice.isVisible()) await choice.click(); // glTF says it itself
  await page.getByRole('button', { name: 'Create scene' }).click();
  await page.waitForFunction((id) => {
    const { scene } = window.latticed;
    return scene !== undefined && scene.session.sceneId !== id && scene.session.surface.patchCount > 0;
  }, before);
}

/** Waits until the page's scene is connected, its surface has come, and the camera looks at it. */
export async function live(of: Page): Promise<void> {
  await of.locator('.connection[data-state=live]').waitFor();
  await of.waitForFunction(() => (window.latticed.scene?.session.surface.patchCount ?? 0) > 0);
  await frames(of);
}

/** Waits until the surface has this number of segments. It comes some time after it was asked for. */
export async function segmentsCome(of: Page, segments: number): Promise<void> {
  await of.waitForFunction((n) =>
    window.latticed.scene!.session.surface.layout?.segments === n, segments);
}

/** Waits until the page has a control point at a place. */
export async function pointComesTo(of: Page, index: number, place: Vec3): Promise<void> {
  await of.waitForFunction(([i, x, y, z]) => {
    const { points } = window.latticed.scene!.session.lattice;
    return Math.hypot(points[3 * i] - x, points[3 * i + 1] - y, points[3 * i + 2] - z) < 1e-9;
  }, [index, ...place] as const);
}

/**
 * Waits until all changes are drawn, in full detail: a press hits a handle where it was drawn last. Frames wait while the
 * graphics processor is busy, and are coarse while something moves.
 */
export function frames(of: Page): Promise<void> {
  return of.evaluate(() => new Promise((resolve, reject) => {
    const { viewport } = window.latticed;
    const end = performance.now() + 60_000;
    const next = (left: number): void => {
      if (left <= 0 && viewport.isFine) resolve();
      else if (performance.now() > end) reject(new Error('a frame is wanted, again and again'));
      else requestAnimationFrame(() => next(left - 1));
    };
    next(2); // the first frame takes in the changes
  }));
}

/** The position of a control point in the world. */
export function controlPoint(of: Page, index: number): Promise<Vec3> {
  return of.evaluate(
    (i) => [...window.latticed.scene!.session.lattice.points.slice(3 * i, 3 * i + 3)] as unknown as Vec3,
    index,
  );
}

/** The position of a world point on the screen, in pixels of the page. */
export function placeOf(of: Page, point: Vec3): Promise<[number, number]> {
  return of.evaluate((p) => {
    const { viewport } = window.latticed;
    const [x, y] = viewport.project(p)!;
    const box = viewport.canvas.getBoundingClientRect();
    return [box.left + x, box.top + y];
  }, point);
}

/** The position of a control point on the screen, in pixels of the page. */
export async function onScreen(of: Page, index: number): Promise<[number, number]> {
  return placeOf(of, await controlPoint(of, index));
}

/** The position on the screen of the handle that moves along Z, if the handles are at `point`. */
export function upperHandle(of: Page, point: Vec3): Promise<[number, number]> {
  return of.evaluate(([px, py, pz]) => {
    const { viewport } = window.latticed;
    const [x, y] = viewport.project([px, py, pz])!;
    const [ux, uy] = viewport.project([px, py, pz + 0.1])!;
    const box = viewport.canvas.getBoundingClientRect();
    const along = (0.08 * box.height) / Math.hypot(ux - x, uy - y); // handles keep their size on the screen
    return [box.left + x + along * (ux - x), box.top + y + along * (uy - y)];
  }, point);
}

export interface Camera {
  /** Right, up and towards the viewer. */
  basis: Basis;
  position: Vec3;
  target: Vec3;
}

export function camera(of: Page): Promise<Camera> {
  return of.evaluate(() => {
    const { rig } = window.latticed.viewport;
    return {
      basis: rig.basis(),
      position: rig.camera.position.toArray() as unknown as Vec3,
      target: rig.target.toArray() as unknown as Vec3,
    };
  });
}

/** The colour of the view, 0 to 255, at `right` pixels to the right of a point of the world. */
export function colourAt(page: Page, point: Vec3, right = 0): Promise<[number, number, number]> {
  return page.evaluate(
    ([p, aside]) => {
      const { viewport } = window.latticed;
      const [px, py] = viewport.project(p)!;
      viewport.renderer.render(viewport.scene, viewport.rig.camera);
      const gl = viewport.renderer.getContext();
      const ratio = viewport.renderer.getPixelRatio();
      const pixel = new Uint8Array(4);
      gl.readPixels((px + aside) * ratio, gl.drawingBufferHeight - 1 - py * ratio, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      return [pixel[0], pixel[1], pixel[2]] as [number, number, number];
    },
    [point, right] as const,
  );
}

/** Does something, and waits until it has changed this number of pixels of the view or more. */
export async function changesView(of: Page, pixels: number, act: () => Promise<void>): Promise<void> {
  await frames(of);
  await of.evaluate(() => {
    const { viewport } = window.latticed;
    const gl = viewport.renderer.getContext();
    const read = (): Uint32Array => {
      const all = new Uint32Array(gl.drawingBufferWidth * gl.drawingBufferHeight);
      viewport.renderer.render(viewport.scene, viewport.rig.camera);
      gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(all.buffer));
      return all;
    };
    const before = read();
    const changed = (): number =>
      viewport.isFine ? read().reduce((count, pixel, i) => count + Number(pixel !== before[i]), 0) : 0;
    Object.assign(window, { changed });
  });
  await act();
  await of.waitForFunction((n) => (window as unknown as { changed(): number }).changed() >= n, pixels, { polling: 50 });
}

/** The bytes of a download. */
export async function saved(download: Download): Promise<Buffer> {
  return readFileSync(await download.path());
}

/** A lattice at rest in a frame. `points` is the number of control points along each axis. */
export function latticeIn([origin, u, v, w]: readonly [Vec3, Vec3, Vec3, Vec3], points: number, degree: number): Lattice {
  const knots = knotVectors(() => clampedUniformKnots(degree, points));
  const structure = { frame: { origin, u, v, w }, degree: [degree, degree, degree], size: [points, points, points], knots } as const;
  return new Lattice(structure.frame, structure.degree, structure.size, knots, identityPoints(structure));
}
