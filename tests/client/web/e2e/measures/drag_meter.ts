// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures a drag on the viewer's page by time stamps inside the page.
import type { CDPSession, Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import type { UpdateInfo } from '@src/session/scene_session';

/** In milliseconds, except `seconds`. */
export interface Measured {
  /** From the newest own edit in an update until its points are in the vertex buffer; the same of evaluations by the page. */
  readonly points: readonly number[];
  /** Updates of own edits. */
  readonly updates: readonly UpdateInfo[];
  /** For each frame that shows new points: from that edit until its pixels are drawn. */
  readonly toPixels: readonly number[];
  /** For the same frames: from a frame's first call until its pixels are drawn. */
  readonly drawing: readonly number[];
  readonly seconds: number;
}

interface Meter {
  readonly points: number[];
  readonly updates: UpdateInfo[];
  readonly toPixels: number[];
  readonly drawing: number[];
  began: number;
  /** The revision of the newest update. */
  revision: number;
}

type MeteredWindow = Window & { meter: Meter };

export interface Wanted {
  /** How often points are to come. */
  readonly points: number;
  readonly frames: number;
}

const MOVE_MS = 8; // a mouse reports 125 times per second
const WARM_UP: Wanted = { points: 5, frames: 2 };

/** Drags control points of a page's scene with the key G and the mouse. */
export class DragMeter {
  private constructor(private readonly page: Page, private readonly mouse: CDPSession) {}

  static async of(page: Page): Promise<DragMeter> {
    await page.evaluate(install);
    return new DragMeter(page, await page.context().newCDPSession(page));
  }

  /** Drags these control points until `wanted` is measured. The drag is cancelled at its end. */
  async measure(indices: readonly number[], wanted: Wanted): Promise<Measured> {
    await this.page.evaluate((points) => window.latticed.scene!.editor.selection.select(points), [...indices]);
    const box = (await this.page.locator('canvas').boundingBox())!;
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await this.page.mouse.move(x, y);
    await this.page.keyboard.press('g');
    await this.move(x, y, WARM_UP);
    await this.page.evaluate(() => {
      const { meter } = window as unknown as MeteredWindow;
      meter.points.length = meter.updates.length = meter.toPixels.length = meter.drawing.length = 0;
      meter.began = performance.now();
    });
    await this.move(x, y, wanted);
    const measured = await this.page.evaluate(() => {
      const { points, updates, toPixels, drawing, began } = (window as unknown as MeteredWindow).meter;
      return { points: [...points], updates: [...updates], toPixels: [...toPixels], drawing: [...drawing], seconds: (performance.now() - began) / 1000 };
    });
    await this.page.keyboard.press('Escape');
    return measured;
  }

  /** Waits until the page has an update of this revision or a newer one. */
  async reached(revision: number): Promise<void> {
    await this.page.waitForFunction((least) => (window as unknown as MeteredWindow).meter.revision >= least, revision);
  }

  /** Moves the mouse around (x, y) until all that is wanted has come. */
  private async move(x: number, y: number, wanted: Wanted): Promise<void> {
    for (let step = 1; !(await this.has(wanted)); ++step) {
      const angle = (2 * Math.PI * step) / 96;
      const place = { x: x + 24 * Math.sin(angle), y: y + 12 * Math.sin(2 * angle + 1) };
      await Promise.all([
        this.mouse.send('Input.dispatchMouseEvent', { type: 'mouseMoved', ...place, buttons: 0 }),
        new Promise((resolve) => setTimeout(resolve, MOVE_MS)),
      ]);
    }
  }

  private has({ points, frames }: Wanted): Promise<boolean> {
    return this.page.evaluate(([p, f]) => {
      const { meter } = window as unknown as MeteredWindow;
      return meter.points.length >= p && meter.toPixels.length >= f;
    }, [points, frames] as const);
  }
}

/** Runs in the page. */
function install(): void {
  const LOOK_MS = 4; // the shortest timer of browsers; polling all the time would slow the drawing
  const { viewport, scene } = window.latticed;
  const meter: Meter = { points: [], updates: [], toPixels: [], drawing: [], began: 0, revision: -1 };
  Object.assign(window, { meter });
  let undrawn: number | undefined; // the time of the edit whose points no frame shows yet
  let frameBegan = 0;
  /** Calls return before the GPU has done them. A fence tells when it has. */
  const onceDone = (then: () => void): void => {
    const gl = viewport.renderer.getContext() as WebGL2RenderingContext;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0)!;
    gl.flush();
    const look = (): void => {
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return void setTimeout(look, LOOK_MS);
      gl.deleteSync(fence);
      then();
    };
    setTimeout(look);
  };
  scene!.session.on('update', (info) => {
    meter.revision = info.revision;
    // Where the page evaluates points, an update brings bounds, and none if no bound has changed.
    if (info.msFromEdit === undefined || (info.patchesSent === 0 && !scene!.isEvaluated)) return;
    meter.updates.push(info);
    if (scene!.isEvaluated) return;
    undrawn = performance.now() - info.msFromEdit;
    meter.points.push(info.msFromEdit);
  });
  const tell = scene!.onEvaluated;
  scene!.onEvaluated = (ms) => {
    tell?.(ms);
    const edit = (undrawn = performance.now() - ms);
    onceDone(() => meter.points.push(performance.now() - edit));
  };
  viewport.onFrame(() => (frameBegan = performance.now()));
  viewport.onDrawn(() => {
    if (undrawn === undefined) return;
    const [edit, began] = [undrawn, frameBegan];
    undrawn = undefined;
    onceDone(() => {
      meter.toPixels.push(performance.now() - edit);
      meter.drawing.push(performance.now() - began);
    });
  });
}
