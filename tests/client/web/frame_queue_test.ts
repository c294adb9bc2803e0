// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { FrameQueue } from '@src/viewport/frame_queue';

/** Fences that the test signals. */
class FakeGraphics {
  readonly SYNC_STATUS = 0x9114;
  readonly SIGNALED = 0x9119;
  readonly UNSIGNALED = 0x9118;
  readonly SYNC_GPU_COMMANDS_COMPLETE = 0x9117;
  readonly open: { isSignaled: boolean }[] = [];
  isLost = false;
  flushed = 0;

  fenceSync(): { isSignaled: boolean } | null {
    if (this.isLost) return null;
    const fence = { isSignaled: false };
    this.open.push(fence);
    return fence;
  }

  flush(): void {
    ++this.flushed;
  }

  getSyncParameter({ isSignaled }: { isSignaled: boolean }): number | null {
    if (this.isLost) return null;
    return isSignaled ? this.SIGNALED : this.UNSIGNALED;
  }

  deleteSync(fence: { isSignaled: boolean }): void {
    this.open.splice(this.open.indexOf(fence), 1);
  }
}

function queueOf(graphics: FakeGraphics): { queue: FrameQueue; seen: number[]; draw(number: number): Promise<void> } {
  const queue = new FrameQueue(graphics as unknown as WebGL2RenderingContext);
  const seen: number[] = [];
  return { queue, seen, draw: (number) => queue.add().then(() => void seen.push(number)) };
}

test('two frames that take little may be on their way; of those that take long one, which is told when it is seen', async (t) => {
  let now = 1000;
  t.mock.method(performance, 'now', () => now);
  const graphics = new FakeGraphics();
  const { queue, seen, draw } = queueOf(graphics);
  const finish = async (after: number, frames: Promise<void>[]): Promise<void> => {
    now += after;
    for (const fence of graphics.open) fence.isSignaled = true;
    queue.poll();
    await Promise.all(frames);
  };

  const first = draw(1);
  assert.equal(queue.isFull, false);
  const second = draw(2);
  assert.ok(queue.isFull);
  graphics.open[0].isSignaled = true;
  now += 16;
  queue.poll();
  await first;
  assert.deepEqual(seen, [1]);
  assert.equal(queue.isFull, false);
  await finish(16, [second]);
  assert.ok(queue.isEmpty);

  const slow = draw(3);
  await finish(300, [slow]);
  const alone = draw(4);
  assert.ok(queue.isFull, 'a second one would be 300 ms late');
  await finish(300, [alone]);
  const quick = draw(5);
  await finish(10, [quick]);
  const overlapped = [draw(6), draw(7)];
  assert.ok(queue.isFull);
  await finish(80, overlapped); // 40 ms each
  void draw(8);
  assert.equal(queue.isFull, false);
  assert.deepEqual(seen, [1, 2, 3, 4, 5, 6, 7]);
  assert.equal(graphics.open.length, 1, 'fences are given back');
  assert.equal(graphics.flushed, 8);
});

test('a graphics processor that is lost holds up nothing', async () => {
  const graphics = new FakeGraphics();
  const { queue, seen, draw } = queueOf(graphics);
  const before = draw(1);
  graphics.isLost = true;
  queue.poll();
  await before;
  await draw(2);

  assert.deepEqual(seen, [1, 2]);
  assert.ok(queue.isEmpty);
});
