// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How events become the vertex buffer, without a GPU.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import type { InterleavedBufferAttribute } from 'three';
import { ChunksSchema, QuantisationSchema, TopologySchema, UpdateBeginSchema, UpdateEndSchema } from 'latticed/v1/event_pb';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { UpdateReceiver, type ReceivedUpdate } from '@src/session/update_receiver';
import { PointBuffer } from '@src/surface/point_buffer';
import { SurfaceMesh } from '@src/surface/surface_mesh';
import { TopologyLayout } from '@src/surface/topology_layout';
import { FakeWorker, poolOf } from '../support/fake_worker';
import { noPatches, until } from '../support/session_fixture';

// Three patches of one triangle each. Patches 0 and 1 are chunk 0; patch 2 is chunk 1.
const topology = create(TopologySchema, {
  topologyId: 't', patchCount: 3n, pointCount: 9n, triangleCount: 3n, segments: 1,
  chunkRuns: [{ chunkCount: 1, patchesPerChunk: 2 }, { chunkCount: 1, patchesPerChunk: 1 }],
  pattern: { points: [1, 0, 0, 0, 1, 0, 0, 0, 1], triangles: [0, 1, 2] },
});
const grid = create(QuantisationSchema, { quantisationId: 1n, origin: { x: 1e6, y: 0, z: -2 }, step: 0.5, bits: 12 });
const view = { encoding: Encoding.QUANTISED, normals: NormalMode.NONE };

/** A chunk whose points all lie at (value, value, value). */
function chunk(index: number, points: number, value: number): { index: number; data: Uint8Array<ArrayBuffer>; levels?: Uint8Array<ArrayBuffer> } {
  return { index, data: new Uint8Array(Uint16Array.from({ length: 3 * points }, () => value).buffer) };
}

class Receiving {
  readonly worker: FakeWorker;
  readonly got: ReceivedUpdate[] = [];
  readonly failures: string[] = [];
  readonly receiver: UpdateReceiver;

  constructor(atOnce: boolean) {
    this.worker = new FakeWorker(atOnce);
    this.receiver = new UpdateReceiver(
      poolOf(this.worker), (update) => this.got.push(update), (error) => this.failures.push(error.message));
    this.receiver.topology(topology);
    this.receiver.quantisation(grid);
  }

  begin(updateId: bigint): void {
    this.receiver.begin(create(UpdateBeginSchema, { updateId, revision: updateId, view }));
  }

  chunks(updateId: bigint, ...chunks: ReturnType<typeof chunk>[]): void {
    this.receiver.chunks(create(ChunksSchema, { updateId, topologyId: 't', quantisationId: 1n, chunks }));
  }

  end(updateId: bigint): void {
    this.receiver.end(create(UpdateEndSchema, { updateId, revision: updateId }));
  }
}

test('an update is shown whole, in world units about an origin far away', async () => {
  const receiving = new Receiving(true);
  const surface = new SurfaceMesh(noPatches);
  receiving.begin(1n);
  receiving.chunks(1n, chunk(0, 6, 4));
  receiving.chunks(1n, chunk(1, 3, 10));
  receiving.end(1n);
  await until(() => receiving.got.length === 1);

  surface.apply(receiving.got[0].surface!);

  assert.deepEqual([receiving.got[0].bytes, receiving.got[0].patches], [54, 3]);
  assert.deepEqual(surface.positionOf(5), [1e6 + 2, 2, 0]);
  assert.deepEqual(surface.positionOf(6), [1e6 + 5, 5, 3]);
  assert.deepEqual([surface.bounds.min.toArray(), surface.bounds.max.toArray()], [[1e6 + 2, 2, 0], [1e6 + 5, 5, 3]]);
  assert.equal(surface.patchCount, 3);
});

test('where the next update has ended before one is decoded, both are one, and nothing is decoded twice', async () => {
  const receiving = new Receiving(false);
  receiving.begin(1n);
  receiving.chunks(1n, chunk(0, 6, 1), chunk(1, 3, 1), chunk(0, 6, 1));
  receiving.end(1n);
  receiving.begin(2n);
  receiving.chunks(2n, chunk(0, 6, 2));
  receiving.end(2n);
  await until(async () => (await receiving.worker.work(), receiving.got.length === 1));

  const { end, surface, patches, bytes } = receiving.got[0];
  assert.equal(end.updateId, 2n);
  assert.deepEqual([patches, bytes], [3, 126]); // counts each patch once, but all bytes
  assert.deepEqual(surface!.chunks.map(({ index, decoded }) => [index, decoded.points[0]]).sort(), [[0, 2], [1, 1]]);
});

test('an update that begins anew, or whose stream is lost, is not shown', async () => {
  const receiving = new Receiving(true);
  receiving.begin(1n);
  receiving.chunks(1n, chunk(0, 6, 1));
  receiving.begin(2n);
  receiving.chunks(2n, chunk(1, 3, 2));
  receiving.receiver.reset();
  receiving.end(2n);
  receiving.begin(3n);
  receiving.end(3n);
  await until(() => receiving.got.length === 1);

  assert.equal(receiving.got[0].end.updateId, 3n);
  assert.equal(receiving.got[0].surface, undefined);
});

test('a chunk that cannot be decoded fails the update; one of an unknown layout or number is refused', async () => {
  const receiving = new Receiving(true);
  receiving.begin(1n);
  receiving.chunks(1n, chunk(0, 5, 1));
  receiving.end(1n);
  await until(() => receiving.failures.length === 1);

  assert.match(receiving.failures[0], /30 bytes, not 36/);
  receiving.begin(2n);
  assert.throws(() => receiving.chunks(2n, chunk(2, 3, 1)), /chunk 2 of 2/);
  assert.throws(() => receiving.receiver.chunks(create(ChunksSchema, { topologyId: 'other', quantisationId: 1n })), /not sent/);
});

test('with a tolerance, the levels of a chunk say how many points its patches have, and change with an update', async () => {
  const receiving = new Receiving(true);
  const surface = new SurfaceMesh(noPatches);
  receiving.receiver.topology(create(TopologySchema, { ...topology, segments: 0, pointCount: 0n, triangleCount: 0n, pattern: undefined }));
  const levels = (...codes: number[]): Uint8Array<ArrayBuffer> => new Uint8Array(Uint16Array.from(codes).buffer);
  const apply = async (updateId: bigint, ...chunks: (ReturnType<typeof chunk> & { levels: Uint8Array<ArrayBuffer> })[]): Promise<void> => {
    receiving.begin(updateId);
    receiving.chunks(updateId, ...chunks);
    receiving.end(updateId);
    await until(() => receiving.got.length === Number(updateId));
    surface.apply(receiving.got.at(-1)!.surface!);
  };
  const heights = (): number[] => {
    const all: number[] = [];
    surface.places.eachPatch(1, (_, { points }, firstPoint) =>
      points.forEach((_entry, n) => all.push(surface.positionOf(firstPoint + n)[2])));
    return all;
  };

  await apply(1n, { ...chunk(0, 6, 4), levels: levels(0, 0) }, { ...chunk(1, 6, 6), levels: levels(0o111) });
  assert.equal(receiving.got[0].bytes, 72 + 6);
  assert.deepEqual(heights(), [...Array(6).fill(0), ...Array(6).fill(1)]);
  await apply(2n, { ...chunk(0, 18, 8), levels: levels(0, 0o222) }); // 15 points in the second patch
  assert.deepEqual(heights(), [...Array(18).fill(2), ...Array(6).fill(1)]);
  assert.deepEqual(surface.triangles, [1 + 16 + 4, 3]);
});

test('all of a chunk is sent that is written after a coarser one of the same first point, and before the next frame', () => {
  const buffer = new PointBuffer();
  const layoutOf = (segments: number): TopologyLayout => {
    const points = ((segments + 1) * (segments + 2)) / 2;
    return new TopologyLayout(create(TopologySchema, {
      topologyId: `${segments}`, segments, patchCount: 4n, pointCount: BigInt(4 * points),
      chunkRuns: [{ chunkCount: 1, patchesPerChunk: 4 }], pattern: { points: Array(3 * points).fill(0) },
    }));
  };
  const data = (buffer.prepare(layoutOf(10), false).getAttribute('position') as InterleavedBufferAttribute).data;
  data.onUploadCallback();
  for (const segments of [1, 10, 1]) {
    const layout = layoutOf(segments);
    buffer.prepare(layout, false);
    buffer.write(0, new Uint16Array(6 * layout.pointsOf(0, new Uint16Array())).fill(segments));
  }

  assert.deepEqual(data.updateRanges, [{ start: 0, count: 6 * 4 * 66 }]); // 6 per point; four patches of 66 points
});
