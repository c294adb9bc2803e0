// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { FrameQueue } from '@src/viewport/frame_queue';

/** Fences that the test signals. */
class FakeGraphics {
  readonly UNSIGNALED = 0x9118;
  readonly open: { isSignaled: boolean }[] = [];
  isLost = false;

  fenceSync(): { isSignaled: boolean } | null {
    if (this.isLost) return null;
    const fence = { isSignaled: false };
    this.open.push(fence);
    return fence;
  }

  flush(): void {}

  getSyncParameter({ isSignaled }: { isSignaled: boolean }): number | null {
    return this.isLost ? null : this.UNSIGNALED + Number(isSignaled);
  }

  deleteSync(fence: { isSignaled: boolean }): void {
    this.open.splice(this.open.indexOf(fence), 1);
  }
}

test('two frames that take little may be on their way; of those that take long one', async (t) => {
  let now = 1000;
  t.mock.method(performance, 'now', () => now);
  const graphics = new FakeGraphics();
  const queue = new FrameQueue(graphics as unknown as WebGL2RenderingContext);
  /** Draws frames that are finished `ms` later. Returns whether the queue had room for another frame. */
  const draw = async (frames: number, ms: number): Promise<boolean> => {
    const done = Array.from({ length: frames }, () => queue.add());
    const hasRoom = !queue.isFull;
    now += ms;
    for (const fence of graphics.open) fence.isSignaled = true;
    queue.poll();
    await Promise.all(done);
    return hasRoom;
  };

  assert.equal(await draw(1, 16), true);
  assert.equal(await draw(2, 32), false);
  assert.equal(await draw(1, 300), true);
  assert.equal(await draw(1, 10), false, 'a second one would be 300 ms late');
  assert.equal(await draw(1, 10), true);
  assert.ok(queue.isEmpty);
  assert.equal(graphics.open.length, 0, 'fences are given back');
});

test('a graphics processor that is lost holds up nothing', async () => {
  const graphics = new FakeGraphics();
  const queue = new FrameQueue(graphics as unknown as WebGL2RenderingContext);
  const before = queue.add();
  graphics.isLost = true;
  queue.poll();
  await before;
  await queue.add();

  assert.ok(queue.isEmpty);
});
