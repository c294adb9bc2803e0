// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Page } from 'playwright-core';

export type Place = readonly [number, number];

const STEPS = 8;

/**
 * Puts fingers down one after the other and moves them along their ways. They rest at the end, because Chromium
 * ignores a tap soon after a fling.
 *
 * @param alone The part of its way, 0 to 1, that the first finger has gone when the others come.
 */
export async function swipe(page: Page, ways: readonly (readonly [from: Place, to: Place])[], alone = 0): Promise<void> {
  const session = await page.context().newCDPSession(page);
  /** Sends an event with the first `fingers` fingers at the part `along` of their ways. */
  const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', along: number, fingers = ways.length): Promise<unknown> => {
    const touchPoints = ways.slice(0, fingers).map(([from, to], id) => {
      const done = id > 0 ? Math.max(along - alone, 0) / (1 - alone) : along;
      return { id, x: from[0] + done * (to[0] - from[0]), y: from[1] + done * (to[1] - from[1]) };
    });
    return session.send('Input.dispatchTouchEvent', { type, touchPoints });
  };
  await touch('touchStart', 0, 1);
  for (let step = 1; step <= STEPS * alone; ++step) await touch('touchMove', step / STEPS, 1);
  for (let fingers = 2; fingers <= ways.length; ++fingers) await touch('touchStart', alone, fingers);
  for (let step = Math.floor(STEPS * alone) + 1; step <= STEPS; ++step) await touch('touchMove', step / STEPS);
  await page.waitForTimeout(100);
  await touch('touchMove', 1);
  await touch('touchEnd', 1, 0);
  await session.detach();
}
