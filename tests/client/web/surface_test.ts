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
import { DecodePool } from '@src/decode/decode_pool';
import { UpdateReceiver, type ReceivedUpdate } from '@src/session/update_receiver';
import { PointBuffer } from '@src/surface/point_buffer';
import { SurfaceMesh } from '@src/surface/surface_mesh';
import { TopologyLayout } from '@src/surface/topology_layout';
import { trianglesOf } from '@src/surface/triangles';
import { FakeWorker } from './support/fake_worker';
import { decoderWasm, noPatches, until } from './support/session_fixture';

// Three patches of one triangle each. Patches 0 and 1 are chunk 0; patch 2 is chunk 1.
const topology = create(TopologySchema, {
  topologyId: 't', patchCount: 3n, pointCount: 9n, triangleCount: 3n, segments: 1,
  chunkRuns: [{ chunkCount: 1, patchesPerChunk: 2 }, { chunkCount: 1, patchesPerChunk: 1 }],
  pattern: { points: [1, 0, 0, 0, 1, 0, 0, 0, 1], triangles: [0, 1, 2] },
});
const grid = create(QuantisationSchema, { quantisationId: 1n, origin: { x: 1e6, y: 0, z: -2 }, step: 0.5, bits: 12 });
const view = { encoding: Encoding.QUANTISED, normals: NormalMode.NONE };

/** A chunk whose points all lie at (value, value, value). */
function chunk(index: number, points: number, value: number): { index: number; data: Uint8Array<ArrayBuffer> } {
  return { index, data: new Uint8Array(Uint16Array.from({ length: 3 * points }, () => value).buffer) };
}

class Receiving {
  readonly worker: FakeWorker;
  readonly got: ReceivedUpdate[] = [];
  readonly failures: string[] = [];
  readonly receiver: UpdateReceiver;

  constructor(atOnce: boolean) {
    this.worker = new FakeWorker(decoderWasm, atOnce);
    this.receiver = new UpdateReceiver(
      new DecodePool([this.worker], decoderWasm), (update) => this.got.push(update), (error) => this.failures.push(error.message));
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
    buffer.write(layout.firstPointOf(0), new Uint16Array(6 * layout.pointCount).fill(segments));
  }

  assert.deepEqual(data.updateRanges, [{ start: 0, count: 6 * 4 * 66 }]); // 6 per point; four patches of 66 points
});

/** A layout of two patches with the server's pattern: rows of points, every second one backwards. */
function patternLayout(segments: number): TopologyLayout {
  const rows = Array.from({ length: segments + 1 }, (_, row) => {
    const columns = Array.from({ length: segments + 1 - row }, (_, column) => [segments - row - column, column, row]);
    return row % 2 === 0 ? columns : columns.reverse();
  });
  const points = rows.flat();
  const at = (column: number, row: number): number => points.findIndex(([, i1, i2]) => i1 === column && i2 === row);
  const triangles = rows.slice(1).flatMap((_, row) => rows[row].flatMap((_, i) => [
    ...(i < segments - row ? [at(i, row), at(i + 1, row), at(i, row + 1)] : []),
    ...(i < segments - row - 1 ? [at(i + 1, row), at(i + 1, row + 1), at(i, row + 1)] : []),
  ]));
  return new TopologyLayout(create(TopologySchema, {
    topologyId: `${segments}`, segments, patchCount: 2n, pointCount: BigInt(2 * points.length),
    chunkRuns: [{ chunkCount: 1, patchesPerChunk: 2 }], pattern: { points: points.flat(), triangles },
  }));
}

for (const [segments, divisors] of [[10, [1, 2, 5, 10]], [7, [1, 7]], [1, [1]]] as const) {
  test(`${segments} segments are drawn over each ${divisors.join(', ')}. row; every detail covers all of each patch, wound alike`, () => {
    const layout = patternLayout(segments);
    const { indices, details } = trianglesOf(layout);

    assert.deepEqual(details.map(({ divisor }) => divisor), divisors);
    for (const { divisor, start, count } of details) {
      assert.equal(count, 3 * 2 * (segments / divisor) ** 2);
      for (const patch of [0, 1]) {
        const [half, first] = [count / 2, patch * layout.pointsPerPatch];
        const own = indices.subarray(start + patch * half, start + (patch + 1) * half);
        const places = Array.from(own, (point) => [...layout.patternPoints.subarray(3 * (point - first), 3 * (point - first) + 3)]);
        assert.ok(places.flat().every((i) => i % divisor === 0));
        const areas = Array.from({ length: half / 3 }, (_, i) => {
          const [a, b, c] = places.slice(3 * i, 3 * i + 3);
          return (b[1] - a[1]) * (c[2] - a[2]) - (c[1] - a[1]) * (b[2] - a[2]);
        });
        assert.deepEqual([...new Set(areas)], [divisor ** 2]);
      }
    }
  });
}
