// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures the frames of an orbit on the viewer's page.
import type { Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed

export interface Orbit {
  readonly framesPerSecond: number;
  /** Of the last frame. */
  readonly triangles: number;
  /** Of the last frame's pixels along a side to those at rest. */
  readonly pixelRatio: number;
}

/** Turns the camera about the z axis by a degree for each frame that the browser offers. */
export function measureOrbit(page: Page, seconds: number): Promise<Orbit> {
  return page.evaluate((ms) => new Promise<Orbit>((resolve) => {
    const { viewport } = window.latticed;
    const { camera } = viewport.rig;
    const ratioAtRest = viewport.renderer.getPixelRatio();
    let drawn = 0;
    viewport.onDrawn(() => ++drawn);
    const began = performance.now();
    const turn = (): void => {
      const passed = performance.now() - began;
      if (passed >= ms) {
        const { triangles } = viewport.renderer.info.render;
        resolve({ framesPerSecond: (1000 * drawn) / passed, triangles, pixelRatio: viewport.renderer.getPixelRatio() / ratioAtRest });
        return;
      }
      const { x, y, z } = camera.position;
      const [c, s] = [Math.cos(Math.PI / 180), Math.sin(Math.PI / 180)];
      camera.position.set(c * x - s * y, s * x + c * y, z);
      camera.lookAt(0, 0, 0);
      viewport.moved();
      requestAnimationFrame(turn);
    };
    requestAnimationFrame(turn);
  }), 1000 * seconds);
}
