// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a drag on the viewer's page takes, by time stamps inside the page.
import type { CDPSession, Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed
import type { UpdateInfo } from '@src/session/scene_session';

/** Milliseconds, but for `seconds`. */
export interface Measured {
  /** Of own edits, each with the time from the newest edit that it holds until its points are in the vertex buffer. */
  readonly updates: readonly (UpdateInfo & { readonly msFromEdit: number })[];
  /** Of each frame that shows another update: from the newest edit that it shows until its pixels are there. */
  readonly toPixels: readonly number[];
  /** Of the same frames: from its first call until its pixels are there. */
  readonly drawing: readonly number[];
  readonly seconds: number;
}

interface Meter {
  readonly updates: (UpdateInfo & { msFromEdit: number })[];
  readonly toPixels: number[];
  readonly drawing: number[];
  began: number;
  /** Of the newest update. */
  revision: number;
}

type MeteredWindow = Window & { meter: Meter };

export interface Wanted {
  readonly updates: number;
  readonly frames: number;
}

const MOVE_MS = 8; // a mouse tells of itself 125 times a second
const WARM_UP: Wanted = { updates: 5, frames: 2 };

/** Moves what is selected of the scene that a page shows, by the key G and the mouse. */
export class DragMeter {
  private constructor(private readonly page: Page, private readonly mouse: CDPSession) {}

  static async of(page: Page): Promise<DragMeter> {
    await page.evaluate(install);
    return new DragMeter(page, await page.context().newCDPSession(page));
  }

  /** The drag is taken back at its end. */
  async measure(indices: readonly number[], wanted: Wanted): Promise<Measured> {
    await this.page.evaluate((points) => window.latticed.scene!.editor.selection.select(points), [...indices]);
    const box = (await this.page.locator('canvas').boundingBox())!;
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await this.page.mouse.move(x, y);
    await this.page.keyboard.press('g');
    await this.move(x, y, WARM_UP);
    await this.page.evaluate(() => {
      const { meter } = window as unknown as MeteredWindow;
      meter.updates.length = meter.toPixels.length = meter.drawing.length = 0;
      meter.began = performance.now();
    });
    await this.move(x, y, wanted);
    const measured = await this.page.evaluate(() => {
      const { updates, toPixels, drawing, began } = (window as unknown as MeteredWindow).meter;
      return { updates: [...updates], toPixels: [...toPixels], drawing: [...drawing], seconds: (performance.now() - began) / 1000 };
    });
    await this.page.keyboard.press('Escape');
    return measured;
  }

  /** Waits until the page has an update of this revision or a newer one. */
  async reached(revision: number): Promise<void> {
    await this.page.waitForFunction((least) => (window as unknown as MeteredWindow).meter.revision >= least, revision);
  }

  /** Around the middle, until all that is wanted has come. */
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

  private has({ updates, frames }: Wanted): Promise<boolean> {
    return this.page.evaluate(([u, f]) => {
      const { meter } = window as unknown as MeteredWindow;
      return meter.updates.length >= u && meter.toPixels.length >= f;
    }, [updates, frames] as const);
  }
}

/** Runs in the page. */
function install(): void {
  const LOOK_MS = 4; // browsers allow no less, and to look all the time takes a processor from what draws
  const { viewport, scene } = window.latticed;
  const meter: Meter = { updates: [], toPixels: [], drawing: [], began: 0, revision: -1 };
  Object.assign(window, { meter });
  let undrawn: number | undefined; // when the newest edit was made that an update has brought and no frame shows
  let frameBegan = 0;
  scene!.session.on('update', (info) => {
    meter.revision = info.revision;
    if (info.msFromEdit === undefined || info.patchesSent === 0) return;
    undrawn = performance.now() - info.msFromEdit;
    meter.updates.push({ ...info, msFromEdit: info.msFromEdit });
  });
  viewport.onFrame(() => (frameBegan = performance.now()));
  viewport.onDrawn(() => {
    if (undrawn === undefined) return;
    const [edit, began] = [undrawn, frameBegan];
    undrawn = undefined;
    // The calls of a frame return before it is drawn: a fence tells when it is.
    const gl = viewport.renderer.getContext() as WebGL2RenderingContext;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0)!;
    gl.flush();
    const look = (): void => {
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return void setTimeout(look, LOOK_MS);
      gl.deleteSync(fence);
      meter.toPixels.push(performance.now() - edit);
      meter.drawing.push(performance.now() - began);
    };
    setTimeout(look);
  });
}
