// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The sum of several lattices, which comes with the updates of patches.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { ChunksSchema, PatchLatticeSchema, TopologySchema, UpdateBeginSchema, UpdateEndSchema, type PatchLattice } from 'latticed/v1/event_pb';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import type { DecodePool } from '@src/decode/decode_pool';
import { EdgeBounds } from '@src/patches/levels/edge_bounds';
import { movedPoints, SummedLattice } from '@src/session/summed_lattice';
import { UpdateReceiver, type ReceivedUpdate } from '@src/session/update_receiver';
import { fromLattice } from '@src/wire/lattice_message';
import { cubeLattice } from '../support/session_fixture';

const message = (news: MessageInitShape<typeof PatchLatticeSchema>['news']): PatchLattice => create(PatchLatticeSchema, { news });
const whole = (): PatchLattice => message({ case: 'state', value: { lattice: fromLattice(cubeLattice()), structureId: 1n } });
const moved = (index: number, x: number): PatchLattice =>
  message({ case: 'delta', value: { structureId: 1n, indices: [index], positions: [x, 0, 0] } });

test('each message gives a lattice, and older ones stay as they are', () => {
  const summed = new SummedLattice();
  const first = summed.take(whole());
  const second = summed.take(moved(1, 0.75));
  const third = summed.take(moved(2, 2));

  assert.deepEqual([first, second, third].map(({ points }) => [points[3], points[6]]), [[0.5, 1], [0.75, 1], [0.75, 2]]);
  assert.deepEqual(movedPoints(first, third), [1, 2]);
  assert.deepEqual(movedPoints(third, third), []);
  assert.equal(third.strength, 1);
});

test('what contradicts the sum before is refused', () => {
  assert.throws(() => new SummedLattice().take(moved(0, 0)), /without the one before/);
  const summed = new SummedLattice();
  summed.take(whole());
  assert.throws(() => summed.take(moved(27, 0)), /does not exist/);
  const short = message({ case: 'delta', value: { structureId: 1n, indices: [1, 2], positions: [0, 0, 0] } });
  assert.throws(() => summed.take(short), /do not fit/);
  const state = { lattice: { ...fromLattice(cubeLattice()), controlPoints: [0, 0, 0] }, structureId: 1n };
  assert.throws(() => summed.take(message({ case: 'state', value: state })), /3 coordinates of control points in place of 81/);
  assert.deepEqual([...summed.take(moved(1, 0.5)).points], [...cubeLattice().points], 'the sum is as it was');
});

/** Takes updates of patches, with bounds if an edge `bends` otherwise. */
class Received {
  readonly updates: ReceivedUpdate[] = [];
  readonly bounds = new EdgeBounds();
  private readonly receiver = new UpdateReceiver(undefined as unknown as DecodePool, (update) => {
    this.updates.push(update);
    if (update.edges) this.bounds.take(update.edges);
    this.bounds.updated(undefined, update.sum);
  }, (error) => assert.fail(error));

  constructor() {
    this.receiver.topology(create(TopologySchema, { topologyId: 't', patchCount: 1n, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 1 }] }));
  }

  begin(updateId: bigint, sum: PatchLattice): void {
    this.receiver.begin(create(UpdateBeginSchema, { updateId, view: { encoding: Encoding.PATCHES, normals: NormalMode.FACET } }));
    this.receiver.patchLattice(sum);
  }

  end(updateId: bigint, bends: boolean): void {
    const chunks = [{ index: 0, data: Uint8Array.of(1, 2, 3) }];
    if (bends) this.receiver.chunks(create(ChunksSchema, { updateId, topologyId: 't', chunks }));
    this.receiver.end(create(UpdateEndSchema, { updateId, revision: updateId }));
  }

  async settle(): Promise<void> {
    await new Promise((resolve) => setTimeout(resolve, 1));
  }
}

test('the sum is that of the newest update, also where no bound changes, and of one after an update that did not end', async () => {
  const received = new Received();
  received.begin(1n, whole());
  received.end(1n, true);
  await received.settle();
  assert.equal(received.bounds.sum!.points[3], 0.5);
  assert.equal(received.bounds.structure, received.bounds.sum);
  received.begin(2n, moved(1, 0.75));
  received.end(2n, false);
  await received.settle();
  assert.equal(received.bounds.sum!.points[3], 0.75);
  received.begin(3n, moved(2, 2));  // dropped
  received.begin(4n, moved(1, 0.25));
  received.end(4n, true);
  await received.settle();

  assert.deepEqual(received.updates.map(({ sum }) => sum!.points[6]), [1, 1, 2]);
  assert.equal(received.bounds.sum!.points[3], 0.25);
  assert.equal(received.bounds.structure!.size[0], 3);
  received.bounds.clear();
  assert.equal(received.bounds.sum, undefined);
});

test('of two updates that are merged, the newer sum counts', async () => {
  const received = new Received();
  received.begin(1n, whole());
  received.end(1n, true);
  received.begin(2n, moved(1, 0.75));
  received.end(2n, false);
  await received.settle();

  assert.equal(received.updates.length, 1);
  assert.equal(received.bounds.sum!.points[3], 0.75);
});
