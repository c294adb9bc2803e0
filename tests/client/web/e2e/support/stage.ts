// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tests of a file share a server and a page. The files of a process run one after the other, so these are variables.
import { join } from 'node:path';
import { after, before } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import type { Vec3 } from '@src/lattice/vec';
import type {} from '@src/main'; // window.latticed
import type { StreamSettings } from '@src/session/scene_session';
import { LatticedServer } from '@src/wire/latticed_server';
import { until } from '../../support/until';
import { closeContexts, launch, openPage, type PageOptions } from './browser';
import { ServerProcess } from './server_process';
import { torusObj } from './torus';
import { createScene, dropFiles, frames, segmentsCome } from './viewer_page';

export { until };

export let server: ServerProcess;
/** Calls the server directly, not from a page. */
export let direct: LatticedServer;
export let browser: Browser;
export let page: Page;
/** The page's errors, on which tests fail. */
export let errors: string[];

export interface StageOptions {
  /** More options of the server. */
  readonly serverOptions?: readonly string[];
  /** The address of the page, in place of the server's origin. */
  readonly address?: () => string | Promise<string>;
  readonly context?: PageOptions;
  /** Prepares the page before the first test. */
  readonly begin?: () => Promise<unknown>;
}

/** Starts the server and opens the page before the first test of the file, and ends them after the last. */
export function useStage({ serverOptions, address = () => server.origin, context, begin }: StageOptions = {}): void {
  before(async () => {
    server = await ServerProcess.start(process.env.LATTICED_VIEWER!, serverOptions);
    direct = new LatticedServer(server.origin);
    browser = await launch();
    ({ page, errors } = await openPage(browser, await address(), context));
    await begin?.();
  });
  after(async () => {
    await closeContexts();
    await server?.kill();
  });
}

/** The last of 4 x 4 x 4 control points, which nothing hides. */
export const CORNER = 63;
export const OBJ = torusObj(12, 8);

/** Drops OBJ and takes the lattice that is offered. With 2 segments frames draw quickly. */
export async function openTorus(segments = 2): Promise<void> {
  await dropFiles(page, [['torus.obj', OBJ]]);
  await createScene(page);
  await setView({ segments });
  await segmentsCome(page, segments);
  await frames(page);
}

/** With `segments`, all patches have them. */
export async function setView(view: Partial<StreamSettings>, of = page): Promise<void> {
  await of.evaluate((change) => {
    const { settings } = window.latticed;
    const { detail, view: before } = settings.value;
    settings.set({ view: { ...before, ...change }, detail: change.segments === undefined ? detail : 'segments' });
  }, view);
}

/** Saves a screenshot for people if LATTICED_SHOTS names a folder; its edges are smooth. */
export async function shot(name: string, of = page): Promise<void> {
  if (!process.env.LATTICED_SHOTS) return;
  await of.waitForFunction(() => window.latticed.viewport.isSmooth);
  await of.screenshot({ path: join(process.env.LATTICED_SHOTS, `${name}.png`) });
}

export async function press(...keys: string[]): Promise<void> {
  for (const key of keys) await page.keyboard.press(key);
}

export function select(...indices: number[]): Promise<void> {
  return page.evaluate((list) => window.latticed.scene!.editor.selection.select(list), indices);
}

export function selected(): Promise<number[]> {
  return page.evaluate(() => [...window.latticed.scene!.editor.selection.indices]);
}

/** All control points that a page shows. */
export function allPoints(of = page): Promise<number[]> {
  return of.evaluate(() => [...window.latticed.scene!.session.lattice.points]);
}

/** The server's position of a control point of the page's scene. */
export async function pointAtServer(index: number): Promise<number[]> {
  const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  return (await direct.scenes.getLattice({ scene })).lattice!.controlPoints.slice(3 * index, 3 * index + 3);
}

/** Moves the corner. Steps of 1/4 and 1/8 add up without rounding. */
export function moveCorner(offset: Vec3): Promise<void> {
  return page.evaluate(
    ([index, by]) => window.latticed.scene!.session.apply({ kind: 'move', indices: Uint32Array.of(index), offset: by }),
    [CORNER, offset] as const,
  );
}

/** The server's revision of the page's scene. */
export async function revision(): Promise<number> {
  const scene = await page.evaluate(() => window.latticed.scene!.session.sceneId);
  return Number((await direct.scenes.getScene({ scene })).revision);
}
