// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The head-up line, and how long ago the edit was that an update holds, at times that the test sets.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import type { UpdateInfo } from '@src/session/scene_session';
import { Hud } from '@src/ui/overlays/hud';
import { SessionFixture, until } from './support/session_fixture';

/** As much of an element as the line takes. */
class PlainElement {
  title = '';
  private readonly attributes = new Map<string, string>();
  private children: (PlainElement | string)[] = [];

  get textContent(): string {
    return this.children.map((child) => (typeof child === 'string' ? child : child.textContent)).join('');
  }

  set textContent(text: string) {
    this.children = [text];
  }

  setAttribute(name: string, value: string): void {
    this.attributes.set(name, value);
  }

  append(...children: (PlainElement | string)[]): void {
    this.children.push(...children);
  }

  /** The value of the line that has this name. */
  named(name: string): PlainElement | undefined {
    if (this.attributes.get('data-hud') === name) return this;
    return this.children.map((child) => (typeof child === 'string' ? undefined : child.named(name))).find(Boolean);
  }
}

/** Time that goes on when it is told to, with its timers. */
class Clock {
  now = 0;
  readonly timers = new Map<number, { readonly at: number; readonly act: () => void }>();
  private newest = 0;

  constructor(context: TestContext) {
    context.mock.method(performance, 'now', () => this.now);
    context.mock.method(globalThis, 'clearTimeout', (id: number) => void this.timers.delete(id));
    const window = { setTimeout: (act: () => void, ms: number) => (this.timers.set(++this.newest, { at: this.now + ms, act }), this.newest) };
    Object.assign(globalThis, { window, document: { createElement: () => new PlainElement() } });
    context.after(() => ['window', 'document'].forEach((name) => Reflect.deleteProperty(globalThis, name)));
  }

  goTo(time: number): void {
    this.now = time;
    for (const [id, { at, act }] of [...this.timers]) if (at <= time && this.timers.delete(id)) act();
  }
}

const times = { server: 1, transfer: 2.25, decode: 3, upload: 0.5 };

function info(more: Partial<UpdateInfo> = {}): UpdateInfo {
  return { revision: 1, bytes: 12_345, patchesSent: 3, patchesAll: 1384, fullDetail: true, times, ...more };
}

/** A line whose time is the test's, and what it shows under a name. */
function made(context: TestContext): { clock: Clock; hud: Hud; shows: (name: string) => string } {
  const clock = new Clock(context);
  const hud = new Hud();
  return { clock, hud, shows: (name) => (hud.element as unknown as PlainElement).named(name)!.textContent };
}

test('updates of the last second are counted, those that moved nothing are not, and at rest the line falls to 0', (context) => {
  const { clock, hud, shows } = made(context);
  assert.equal(shows('updates'), '–');

  for (const time of [0, 300, 600, 900, 1000]) {
    clock.goTo(time);
    hud.update(info());
  }
  hud.update(info({ patchesSent: 0, bytes: 0 }));

  assert.deepEqual([shows('updates'), shows('bytes'), shows('patches')], ['5', '12.3 kB', '3 / 1,384']);
  const falling: string[] = [];
  for (const time of [1250, 1500, 1750, 2000, 2250]) {
    clock.goTo(time);
    falling.push(shows('updates'));
  }
  assert.deepEqual(falling, ['4', '3', '2', '1', '0']);
  assert.equal(clock.timers.size, 0);
});

test('the latency is the median of the newest, from the edit until the pixels of the frame that shows it are there', async (context) => {
  const { clock, hud, shows } = made(context);
  /** An edit at the clock's time, its update after 4 ms, a frame at once, and its pixels so many ms after the edit. */
  const latency = async (ms: number): Promise<void> => {
    const edited = clock.now;
    clock.goTo(edited + 4);
    hud.update(info({ msFromEdit: 4 }));
    const drawn = hud.drawn(Promise.resolve().then(() => clock.goTo(edited + ms)));
    await hud.drawn(Promise.resolve()); // another frame, which brings no edit
    await drawn;
  };
  hud.update(info()); // somebody else's edit
  await hud.drawn(Promise.resolve());
  assert.equal(shows('latency'), '–');

  const shown: string[] = [];
  for (const ms of [30, 10, 20]) {
    await latency(ms);
    shown.push(shows('latency'));
  }
  assert.deepEqual(shown, ['30', '30', '20']);
  for (let i = 0; i < 31; ++i) await latency(10);
  assert.equal(shows('latency'), '10');
  for (let i = 0; i < 15; ++i) await latency(50);
  assert.equal(shows('latency'), '10');
  await latency(50);
  assert.equal(shows('latency'), '50'); // 16 of the newest 31
  const { title } = (hud.element as unknown as PlainElement).named('latency')!;
  assert.equal(title, 'The newest: server 1.0 ms, transfer 2.3 ms, decoding 3.0 ms, upload 0.5 ms');
});

test('an update says how long ago the own edit was that the server has applied with it, and of others nothing', async (context) => {
  const fixture = await SessionFixture.live();
  context.after(() => fixture.session.close());
  let now = 1000;
  context.mock.method(performance, 'now', () => now);
  const ages: (number | undefined)[] = [];
  fixture.session.on('update', ({ msFromEdit }) => ages.push(msFromEdit));
  const update = async (updateId: bigint, appliedSequence: bigint): Promise<void> => {
    fixture.stream.event({ case: 'updateBegin', value: { updateId, revision: updateId } });
    fixture.stream.event({ case: 'updateEnd', value: { updateId, revision: updateId, appliedSequence } });
    await until(() => ages.length === Number(updateId));
  };

  fixture.session.apply({ kind: 'move', indices: Uint32Array.of(1), offset: [0.1, 0, 0] });
  const [{ sequence }] = fixture.stream.edits;
  now = 1040;
  await update(1n, 0n);
  await update(2n, sequence);
  await update(3n, sequence);

  assert.deepEqual(ages, [undefined, 40, undefined]);
});
