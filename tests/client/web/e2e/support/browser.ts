// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { TestContext } from 'node:test';
import { chromium, type Browser, type BrowserContext, type BrowserContextOptions, type Page } from 'playwright-core';
import type {} from '@src/main'; // window.latticed

const PATIENCE_MS = 120_000; // Playwright's timeout of 30 s is too short on a busy machine
const SMALL = { width: 640, height: 420 }; // a window that software draws quickly
// Each window of Chromium loads two hidden pages for its address bar, which take longer than the viewer: the last two features.
// The switch replaces Playwright's, whose features are the others.
const DISABLED = [
  'AvoidUnnecessaryBeforeUnloadCheckSync', 'BoundaryEventDispatchTracksNodeRemoval', 'DestroyProfileOnBrowserClose',
  'DialMediaRouteProvider', 'GlobalMediaControls', 'HttpsUpgrades', 'LensOverlay', 'MediaRouter', 'PaintHolding',
  'ThirdPartyStoragePartitioning', 'Translate', 'AutoDeElevate', 'RenderDocument', 'OptimizationHints',
  'WebUIOmniboxPopup', 'WebUIOmniboxAimPopup',
];
// Software OpenGL draws the canvas only. If it drew the rest of the page too, tests would take a quarter more of the processor.
const OPTIONS = {
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  timeout: PATIENCE_MS,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
    '--disable-gpu', '--disable-gpu-compositing', '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--disable-background-timer-throttling', '--disable-renderer-backgrounding',
    `--disable-features=${DISABLED.join(',')}`],
};

export interface PageOptions extends BrowserContextOptions {
  /** Whether the viewer smooths edges at rest. Each time that takes software as long as several frames. */
  readonly smooths?: boolean;
}

let shared: Browser | undefined;

/**
 * Starts Debian's Chromium, or the program CHROMIUM, with software OpenGL. Its contexts store nothing on disk. A process that
 * runs several files of tests has one browser: each file closes its contexts.
 */
export async function launch(): Promise<Browser> {
  if (shared?.isConnected()) return shared;
  const browser = await chromium.launch(OPTIONS);
  const newContext = browser.newContext.bind(browser);
  browser.newContext = async ({ smooths, ...options }: PageOptions = {}) => // newPage calls it too
    prepared(await newContext(options), smooths);
  return (shared = browser);
}

/** Closes all pages of the browser that launch() returned. */
export async function closeContexts(): Promise<void> {
  await Promise.all(shared?.contexts().map((context) => context.close()) ?? []);
}

/** Ends the browser that launch() returned. */
export async function closeBrowser(): Promise<void> {
  await shared?.close();
  shared = undefined;
}

async function prepared(context: BrowserContext, smooths = false): Promise<BrowserContext> {
  context.setDefaultTimeout(PATIENCE_MS);
  if (!smooths && !process.env.LATTICED_SHOTS) await context.addInitScript(leaveEdges);
  return context;
}

/** Starts another browser, with a person's profile folder. It is deleted after Chromium, which writes to it until it ends. */
export async function launchWithProfile(t: TestContext): Promise<BrowserContext> {
  const folder = mkdtempSync(join(tmpdir(), 'latticed-profile-'));
  const context = await prepared(await chromium.launchPersistentContext(folder, OPTIONS));
  t.after(async () => {
    await context.close();
    rmSync(folder, { recursive: true, maxRetries: 10 });
  });
  return context;
}

/** Opens a page and records its errors, on which tests fail. The page trusts self-signed certificates. */
export async function openPage(
  browser: Browser, address: string, options: PageOptions = {},
): Promise<{ page: Page; errors: string[] }> {
  const page = await browser.newPage({ viewport: SMALL, ignoreHTTPSErrors: true, ...options });
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => {
    if (message.type() === 'error') errors.push(message.text());
  });
  await page.goto(address);
  return { page, errors };
}

/** In the page: once the viewer is there, it does not smooth edges. */
function leaveEdges(): void {
  let app: typeof window.latticed;
  Object.defineProperty(window, 'latticed', {
    get: () => app,
    set: (made: typeof app) => {
      app = made;
      Object.assign(made.viewport, { supersampling: undefined });
    },
    configurable: true,
  });
}

/** Makes every WebSocket of a context's pages fail, like a proxy that does not know WebSockets. */
export function stopWebSockets(context: BrowserContext): Promise<void> {
  return context.addInitScript(() => {
    window.WebSocket = class {
      onclose?: (event: { code: number; reason: string }) => void;
      constructor() {
        setTimeout(() => this.onclose?.({ code: 1006, reason: '' }));
      }
      close(): void {}
      send(): void {}
    } as unknown as typeof WebSocket;
  });
}

/**
 * Ends Playwright's record of a page's network, of which each frame of a WebSocket is an event in three processes. Then no test
 * can wait for requests. Playwright offers no way: this is inside of the version that package.json names.
 */
export async function ignoreNetwork(page: Page): Promise<void> {
  interface Inside {
    delegate: { _mainFrameSession: { _client: { send(method: 'Network.disable'): Promise<void> } } };
  }
  const { _connection } = page as unknown as { _connection: { toImpl(of: Page): Inside } };
  await _connection.toImpl(page).delegate._mainFrameSession._client.send('Network.disable');
}

/** Limits the bytes that the page's origin may store. */
export async function limitStorage(page: Page, bytes: number): Promise<void> {
  const session = await page.context().newCDPSession(page);
  await session.send('Storage.overrideQuotaForOrigin', { origin: new URL(page.url()).origin, quotaSize: bytes });
}
