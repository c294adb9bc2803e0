// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames of the viewer in Chromium: how many are drawn, and when. Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the
// folder of the viewer.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { launch, openPage } from './browser';
import { ServerProcess } from './server_process';
import { torusObj } from './torus';
import { createScene, dropFiles, live, onScreen } from './viewer_page';

/** What the page drew since it was watched. */
interface Watched {
  drawn: number;
  /** Of those, whose pixels are there. */
  seen: number;
  /** Frames before it whose pixels were not there when one was drawn. */
  ahead: number[];
  /** performance.now() of each one drawn and seen. */
  times: [drawn: number, seen: number][];
}

const LONG = 75; // ms; of frames that are drawn faster, two may overlap

type WatchedWindow = Window & { watched: Watched };

let server: ServerProcess;
let browser: Browser;
let page: Page;
let errors: string[];

function watch(): Promise<void> {
  return page.evaluate(() => {
    const watched: Watched = { drawn: 0, seen: 0, ahead: [], times: [] };
    if (!('watched' in window)) {
      let looked = 0; // when the page looked last which frames are done
      const { frames } = window.latticed.viewport as unknown as { frames: { poll(): void } };
      const poll = frames.poll.bind(frames);
      frames.poll = () => {
        looked = performance.now();
        poll();
      };
      window.latticed.viewport.onDrawn((seen) => {
        const { watched: now } = window as unknown as WatchedWindow;
        const number = now.drawn++;
        queueMicrotask(() => now.ahead.push(number - now.seen)); // by then the page has told of those seen before
        const began = performance.now();
        void seen.then(() => {
          ++now.seen;
          now.times.push([began, looked]);
        });
      });
    }
    Object.assign(window, { watched });
  });
}

const watched = (): Promise<Watched> => page.evaluate(() => (window as unknown as WatchedWindow).watched);

before(async () => {
  server = await ServerProcess.start(process.env.LATTICED_VIEWER!);
  browser = await launch();
  ({ page, errors } = await openPage(browser, server.origin));
  await dropFiles(page, [['torus.obj', torusObj(31, 17)]]);
  await createScene(page);
  await live(page);
});

after(async () => {
  await browser?.close();
  await server?.kill();
});

test('software OpenGL, three times slower with it, draws without antialiasing', async () => {
  const samples = await page.evaluate(() => {
    const gl = window.latticed.viewport.renderer.getContext();
    return gl.getParameter(gl.SAMPLES) as number;
  });
  assert.equal(samples, 0);
});

test('while a point is dragged no frame waits behind two, and where one takes long behind none', async () => {
  const [x, y] = await onScreen(page, 63);
  await page.evaluate(() => window.latticed.scene!.editor.selection.select([63]));
  await page.mouse.move(x, y);
  await watch();
  await page.keyboard.press('g');
  for (let step = 1; (await watched()).seen < 10; ++step) {
    await page.mouse.move(x - 40 * Math.sin(step / 5), y + 20 * Math.sin(step / 7));
  }
  await page.keyboard.press('Enter');

  const { ahead, times } = await watched();
  const took = times.map(([drawn, seen], i) => seen - Math.max(drawn, times[i - 1]?.[1] ?? 0));
  ahead.forEach((count, i) => {
    const isLong = took[i - 1] > LONG && took[i - 2] > LONG; // each frame before it
    assert.ok(count <= (isLong ? 0 : 1), `frame ${i} of ${JSON.stringify({ ahead, took })}`);
  });
  await page.locator('[data-hud=latency]').getByText(/^[1-9]/).waitFor();
});

test('where nothing changes nothing is drawn', async () => {
  await page.waitForFunction(() => {
    const { isWanted, frames } = window.latticed.viewport as unknown as { isWanted: boolean; frames: { isEmpty: boolean } };
    const { sync } = window.latticed.scene!.session as unknown as { sync: { queue: { sent: unknown[] } } };
    const isQuiet = sync.queue.sent.length === 0 && document.querySelector('[data-hud=updates]')!.textContent === '0';
    return isQuiet && !isWanted && frames.isEmpty;
  });
  await watch();
  await page.evaluate(() => new Promise((resolve) => {
    let left = 30;
    const next = (): void => void (--left > 0 ? requestAnimationFrame(next) : resolve(undefined));
    next();
  }));
  assert.equal((await watched()).drawn, 0);
  assert.deepEqual(errors, []);
});
