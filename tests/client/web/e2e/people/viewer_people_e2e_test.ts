// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The people at a scene, in two or three windows: one's own name and colour, and following another's camera.
// Environment: LATTICED, CHROMIUM; LATTICED_VIEWER, the folder of the viewer; LATTICED_SHOTS, a folder for screenshots.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { distance, type Vec3 } from '@src/lattice/vec';
import { openPage } from '../support/browser';
import { illegible } from '../support/legibility';
import { keepToasts } from '../support/restarts';
import { browser, errors, openTorus, page, shot, until, useStage } from '../support/stage';
import { camera, frames, live } from '../support/viewer_page';

const SMALL = { width: 480, height: 360 }; // a window that software draws quickly
const AGREES = 1e-3; // world units; the torus is 3 wide

/** What has not reached a window. */
interface Unheard {
  unheard: { followers(): number; hear(): void };
}

let other: Page;
let otherErrors: string[];

useStage({
  begin: async () => {
    await openTorus();
    ({ page: other, errors: otherErrors } = await openPage(browser, page.url()));
    await live(other);
  },
});

function pause(ms: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, ms));
}

/** Drags empty space, which orbits. */
async function orbit(of: Page, [dx, dy]: readonly [number, number]): Promise<void> {
  const box = (await of.locator('canvas').boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height - 60];
  await of.mouse.move(x, y);
  await of.mouse.down();
  await of.mouse.move(x + dx, y + dy, { steps: 5 });
  await of.mouse.up();
}

async function difference(of = page, and = other): Promise<number> {
  const [a, b] = [await camera(of), await camera(and)];
  return Math.max(distance(a.position, b.position), distance(a.target, b.target));
}

async function isFollowing(of: Page): Promise<boolean> {
  return of.locator('.following').isVisible();
}

async function agrees(of = page, and = other): Promise<void> {
  await until(async () => (await difference(of, and)) < AGREES);
}

function editorOf(of: Page): Promise<string> {
  return of.evaluate(() => window.latticed.scene!.session.editorId);
}

/** Ends all following, looks from another side in each window, and waits until all windows know of that. */
async function part(windows: readonly Page[]): Promise<void> {
  for (const [i, each] of windows.entries()) {
    await each.evaluate(() => window.latticed.toasts.clear());
    await keepToasts(each);
    await each.keyboard.press('Escape');
    await each.keyboard.press(['1', '3', '7'][i]!); // a drag might grasp what an earlier one has turned there
  }
  const places: Record<string, Vec3> = {};
  for (const each of windows) {
    await frames(each);
    assert.equal(await isFollowing(each), false);
    places[await editorOf(each)] = (await camera(each)).position;
  }
  for (const each of windows) {
    await each.waitForFunction(([at, near]) => {
      const others = [...window.latticed.people['others'].entries()];
      return others.length === Object.keys(at).length - 1 && others.every(([id, { following, camera: shown }]) =>
        following === '' && shown !== undefined && Math.hypot(...shown.position.map((c, axis) => c - at[id]![axis]!)) < near);
    }, [places, AGREES] as const);
  }
  for (const [i, each] of windows.entries()) assert.ok((await difference(each, windows[(i + 1) % windows.length])) > 0.1);
}

/** Each window follows the next one, the last one the first, all at the same moment, as nearly as this machine can. */
async function followInACircle(windows: readonly Page[]): Promise<void> {
  const ids = await Promise.all(windows.map(editorOf));
  const at = Date.now() + 200;
  await Promise.all(windows.map((each, i) => each.evaluate(async ([id, then]) => {
    await new Promise((resolve) => setTimeout(resolve, then - Date.now()));
    window.latticed.people['dots']['others'].get(id)!.click();
  }, [ids[(i + 1) % ids.length]!, at] as const)));
}

/** The same, but news reach the windows one after the other, from a `first` on, and only once all have begun. */
async function followUnheard(windows: readonly Page[], first: number): Promise<void> {
  await Promise.all(windows.map((each) => each.evaluate(() => {
    const stream = window.latticed.scene!.session['stream'];
    const take = stream['takePresence'].bind(stream);
    const news: Parameters<typeof take>[0][] = [];
    stream['takePresence'] = (message) => void news.push(message);
    const followers = (): number => new Set(news.filter(({ following }) => following !== '').map(({ editorId }) => editorId)).size;
    const hear = (): void => {
      stream['takePresence'] = take;
      news.forEach(take);
    };
    Object.assign(window, { unheard: { followers, hear } });
  })));
  await followInACircle(windows);
  for (const each of windows) {
    await each.waitForFunction((count) => (window as unknown as Unheard).unheard.followers() === count, windows.length - 1);
    assert.equal(await isFollowing(each), true);
  }
  for (const each of [...windows.slice(first), ...windows.slice(0, first)]) {
    await each.evaluate(() => (window as unknown as Unheard).unheard.hear());
  }
}

/** The cameras come to rest and agree; whoever has the smallest id stands, and is told so. */
async function restTogether(windows: readonly Page[]): Promise<void> {
  const ids = await Promise.all(windows.map(editorOf));
  const least = ids.indexOf([...ids].sort()[0]!);
  const [first, ...rest] = windows;
  const agree = async (): Promise<boolean> => {
    for (const each of rest) if ((await difference(first, each)) > AGREES) return false;
    return true;
  };
  const isAtRest = async (): Promise<boolean> => // all have heard who stands
    String(await Promise.all(windows.map(isFollowing))) === String(ids.map((_, i) => i !== least));
  await until(async () => {
    if (!(await isAtRest()) || !(await agree())) return false;
    await pause(300); // they may meet on the way
    return agree();
  });
  const before = await camera(first!);
  for (const end = Date.now() + 1000; Date.now() < end; await pause(50)) {
    for (const each of windows) {
      assert.ok(distance((await camera(each)).position, before.position) < AGREES, 'they stay where they met');
    }
  }
  assert.deepEqual(await Promise.all(windows.map(isFollowing)), ids.map((_, i) => i !== least));
  await windows[least]!.waitForFunction(() => // since `part`
    (window as unknown as { toasts: string[] }).toasts.some((text) => text.includes('follows you, so your camera stays.')));
  await windows[least]!.locator('.person[title*="Follows you."]').first().waitFor();
}

/** They rest if nobody knew of another, whoever hears of it first, and if news come at any time. */
async function restAfterCircles(windows: readonly Page[]): Promise<void> {
  for (const first of windows.keys()) {
    await part(windows);
    await followUnheard(windows, first);
    await restTogether(windows);
  }
  await part(windows);
  await followInACircle(windows);
  await restTogether(windows);
}

/** Counts from now on how often names, titles and labels of people are written. */
async function countWritten(of: Page): Promise<() => Promise<number>> {
  await of.evaluate(() => {
    const written = { count: 0 };
    Object.assign(window, { written });
    const observer = new MutationObserver(({ length }) => (written.count += length));
    for (const part of document.querySelectorAll('.people, .following-line')) {
      observer.observe(part, { subtree: true, childList: true, characterData: true, attributeFilter: ['title', 'aria-label', 'aria-pressed'] });
    }
  });
  return () => of.evaluate(() => (window as unknown as { written: { count: number } }).written.count);
}

/** Presses the dot of the first window's person in the other window. */
async function follow(): Promise<void> {
  await other.locator('.person:enabled').click();
  await other.locator('.following').waitFor();
}

test('a name and a colour that one chooses are seen by others at once, and remembered', async () => {
  await other.locator('.person').waitFor();
  await page.locator('.dot.you').click();
  await page.getByRole('textbox', { name: 'Name' }).fill('Ada');
  await page.getByRole('radio', { name: 'Teal' }).click();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('ArrowLeft');
  await shot('viewer_you');
  await page.keyboard.press('Enter');

  const dot = other.locator('.person[title="Ada: 0 control points selected. Press to follow."]');
  await dot.waitFor();
  assert.equal(await dot.getAttribute('aria-label'), await dot.getAttribute('title'));
  assert.equal(await dot.evaluate((element) => getComputedStyle(element).backgroundColor), 'rgb(46, 196, 182)');
  const box = (await dot.boundingBox())!;
  assert.ok(box.width >= 24 && box.height >= 24);
  await page.reload();
  await live(page);
  await page.locator('.dot.you[title^="You are Ada."]').waitFor();
  await dot.waitFor();
});

test('Esc leaves name and colour as they are; a name has at most what the server takes', async () => {
  await page.locator('.menu-button').getByText('View', { exact: true }).click();
  await page.getByText('Your name and colour…').click();
  const name = page.getByRole('textbox', { name: 'Name' });
  await name.fill('🦊'.repeat(70));
  assert.equal(await name.inputValue(), '🦊'.repeat(64));
  await page.keyboard.press('Escape');
  await page.locator('dialog').waitFor({ state: 'detached' });

  assert.equal(await page.locator('.dot.you[title^="You are Ada."]').count(), 1);
});

test('a press on a dot follows: the camera stays with theirs as they orbit, zoom and look without perspective', async () => {
  await orbit(page, [90, -30]);
  await follow();
  await other.getByText('Following Ada').waitFor();
  await agrees();
  const written = await countWritten(other);
  for (const by of [[-140, 40], [60, 25]] as const) {
    await orbit(page, by);
    assert.ok((await difference()) < 10, 'the cameras have places');
    await agrees();
  }
  assert.equal(await written(), 0, 'a camera that moves is no news to a screen reader');
  await shot('viewer_following', other);
  assert.deepEqual(await illegible(other, '#f3f5f9'), []);
  await page.mouse.wheel(0, -300);
  await agrees();
  await page.keyboard.press('5');
  await other.waitForFunction(() => 'isOrthographicCamera' in window.latticed.viewport.rig.camera);
  await page.mouse.wheel(0, -300);
  await page.waitForFunction(() => window.latticed.viewport.rig.camera.zoom > 1);
  await until(async () => {
    const [a, b] = await Promise.all([page, other].map((each) => each.evaluate(() => window.latticed.viewport.rig.pose().projection)));
    return 'height' in a! && 'height' in b! && Math.abs(a.height - b.height) < AGREES;
  });
  await page.keyboard.press('5');
  await other.waitForFunction(() => !('isOrthographicCamera' in window.latticed.viewport.rig.camera));
  await agrees();
  assert.equal(await isFollowing(other), true, 'nothing of this was a move of the follower');
});

test('a move of the own camera ends it, and moves nobody else', async () => {
  for (const each of [page, other]) await each.setViewportSize(SMALL); // for this test and the next ones
  await frames(page);
  await agrees();
  const before = await camera(page);
  await orbit(other, [50, 10]);
  await other.locator('.following').waitFor({ state: 'hidden' });
  const own = await camera(other);
  assert.ok((await difference()) > AGREES);
  await orbit(page, [30, 30]);
  await other.waitForFunction((from) => {
    const [shown] = [...window.latticed.people['others'].values()];
    return Math.hypot(...shown!.camera!.position.map((c, i) => c - from[i]!)) > 0.01;
  }, before.position);
  await frames(other);
  assert.deepEqual(await camera(other), own);
});

test('Esc and the button end it', async () => {
  for (const end of [() => other.keyboard.press('Escape'), () => other.getByRole('button', { name: 'Stop', exact: true }).click(),
    () => other.locator('.person').click()]) {
    await follow();
    await end();
    await other.locator('.following').waitFor({ state: 'hidden' });
  }
});

test('two who follow each other come to rest, whoever begins', async () => {
  for (const [first, second] of [[page, other], [other, page]] as const) {
    await part([page, other]);
    await first.locator('.person:enabled').click();
    await agrees();
    await second.locator('.person[title*="Follows you."]').click();
    await restTogether([page, other]);
  }
});

test('two who begin to follow each other at the same moment come to rest', async () => {
  await restAfterCircles([page, other]);
});

test('three come to rest: in a circle, and in a chain behind the last of it', async () => {
  const { page: third, errors: thirdErrors } = await openPage(browser, page.url(), { viewport: SMALL });
  await live(third);
  const windows = [page, other, third];
  await restAfterCircles(windows);

  await part(windows);
  const [lead, middle] = [await camera(page), await camera(other)];
  const press = async (of: Page, followed: Page): Promise<void> => {
    const id = await editorOf(followed);
    await of.evaluate((each) => window.latticed.people['dots']['others'].get(each)!.click(), id);
  };
  await press(third, other);
  await agrees(third, other);
  assert.ok(distance((await camera(third)).position, middle.position) < AGREES);
  await press(other, page);
  await agrees(other, page);
  await agrees(third, page);
  assert.ok(distance((await camera(page)).position, lead.position) < AGREES, 'the last of a chain is not moved');
  assert.deepEqual(await Promise.all(windows.map(isFollowing)), [false, true, true]);
  assert.deepEqual(thirdErrors, []);
  await third.context().close();
  await page.locator('.person').nth(1).waitFor({ state: 'detached' });
});

test('a new connection does not end it, though nobody is known at first', async () => {
  assert.equal(await isFollowing(other), true);
  const sizes = await other.evaluate(() => {
    const { session } = window.latticed.scene!;
    const seen: number[] = [];
    const known = new Promise<number[]>((resolve) =>
      session.on('presence', ({ size }) => void (seen.push(size), size > 0 && seen.length > 1 && resolve(seen))));
    session['stream']['connection'].reopen();
    return known;
  });
  assert.equal(sizes[0], 0);
  await pause(2500); // an absence that goes on would end it
  assert.equal(await isFollowing(other), true);
  await orbit(page, [-60, 20]);
  await agrees();
  assert.equal(await isFollowing(other), true);
});

test('their leaving ends it', async () => {
  assert.equal(await isFollowing(other), true);
  assert.deepEqual(errors, []);
  await page.close();
  await other.locator('.following').waitFor({ state: 'hidden' });
  await other.locator('.person').waitFor({ state: 'detached' });
  assert.deepEqual(otherErrors, []);
});
