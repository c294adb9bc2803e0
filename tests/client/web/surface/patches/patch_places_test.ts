// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the points of patches are, and which triangles they make: with the same segments everywhere, and with a tolerance.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { BufferGeometry, ShaderMaterial, type BufferAttribute } from 'three';
import { TopologySchema } from 'latticed/v1/event_pb';
import { unpacked } from '@src/surface/patches/patch_pattern';
import { PatchPlaces } from '@src/surface/patches/patch_places';
import { PointBuffer } from '@src/surface/point_buffer';
import { TopologyLayout } from '@src/surface/topology_layout';
import { TriangleSides } from '@src/surface/triangle_sides';

const FLAT = 0; // three points, one triangle
const SPLIT = 0o1001; // edge 0 has two segments, sparsely: four points, two triangles
const FOUR = 0o222; // four segments along each edge: 15 points, 16 triangles

/** A layout of two patches in one chunk, with the server's pattern: rows of points, every second one backwards. */
function uniformLayout(segments: number): TopologyLayout {
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
    topologyId: `${segments}`, segments, patchCount: 2n, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 2 }],
    pattern: { points: points.flat(), triangles },
  }));
}

/** A layout with a tolerance: chunks of two patches each. */
function adaptiveLayout(chunks: number): TopologyLayout {
  return new TopologyLayout(create(TopologySchema, {
    topologyId: 'adaptive', patchCount: BigInt(2 * chunks), chunkRuns: [{ chunkCount: chunks, patchesPerChunk: 2 }],
  }));
}

const codes = (...list: number[]): Uint16Array => Uint16Array.from(list);

/** The triangles of a detail that are no points: of each corner its patch, i_1 and i_2. */
function trianglesOf({ places, indices, details }: PatchPlaces, detail: number): number[][][] {
  const { start, count } = details[detail];
  const triangles = Array.from({ length: count / 3 }, (_, i) => [...indices.subarray(start + 3 * i, start + 3 * i + 3)]);
  return triangles.filter(([a, b, c]) => a !== b || b !== c)
    .map((corners) => corners.map((point) => [places[2 * point], ...unpacked(places[2 * point + 1])]));
}

/** Twice the areas of triangles inside their patches. */
function areasOf(triangles: readonly (readonly number[][])[]): number[] {
  return triangles.map(([a, b, c]) => (b[1] - a[1]) * (c[2] - a[2]) - (c[1] - a[1]) * (b[2] - a[2]));
}

for (const [segments, divisors] of [[10, [1, 2, 5, 10]], [7, [1, 7]], [1, [1]]] as const) {
  test(`${segments} segments are drawn over each ${divisors.join(', ')}. row; every detail covers all of each patch, wound alike`, () => {
    const places = new PatchPlaces(uniformLayout(segments));

    assert.equal(places.pointCount, (segments + 1) * (segments + 2));
    assert.equal(places.room, places.pointCount);
    assert.deepEqual(places.triangleCounts, divisors.map((divisor) => 2 * (segments / divisor) ** 2));
    for (const [detail, divisor] of divisors.entries()) {
      const triangles = trianglesOf(places, detail);
      assert.deepEqual(triangles.map(([[patch]]) => patch).sort(), triangles.map((_, i) => Number(2 * i >= triangles.length)));
      assert.ok(triangles.flat(2).every((i, n) => n % 3 === 0 || i % divisor === 0));
      assert.deepEqual([...new Set(areasOf(triangles))], [divisor ** 2]);
    }
  });
}

test('with a tolerance each patch has the points and triangles of its pattern, all of it covered, at both details', () => {
  const places = new PatchPlaces(adaptiveLayout(2));

  const change = places.take([{ index: 0, codes: codes(FLAT, SPLIT) }, { index: 1, codes: codes(FOUR, FLAT) }]);

  assert.ok(change.isWhole && change.isReplaced);
  assert.deepEqual(change.moves, []);
  assert.equal(places.pointCount, 3 + 4 + 15 + 3);
  assert.deepEqual(places.triangleCounts, [1 + 2 + 16 + 1, 4]);
  for (const detail of [0, 1]) {
    const triangles = trianglesOf(places, detail);
    assert.deepEqual(triangles.map(([[patch]]) => patch), detail === 0 ? [0, 1, 1, ...Array<number>(16).fill(2), 3] : [0, 1, 2, 3]);
    for (const patch of [0, 1, 2, 3]) {
      const own = areasOf(triangles.filter((corners) => corners.every(([of]) => of === patch)));
      assert.ok(own.every((area) => area > 0), `patch ${patch}, detail ${detail}`);
      assert.equal(own.reduce((sum, area) => sum + area), 4096 ** 2);
    }
  }
  const firsts: number[][] = [];
  places.eachPatch(1, (patch, pattern, firstPoint) => firsts.push([patch, pattern.points.length, firstPoint - places.firstPointOf(patch >> 1)]));
  assert.deepEqual(firsts, [[0, 3, 0], [1, 4, 3], [2, 15, 0], [3, 3, 15]]);
});

test('a chunk whose patterns need no more than its slot changes alone, also to fewer points; the same patterns change nothing', () => {
  const places = new PatchPlaces(adaptiveLayout(2));
  places.take([{ index: 0, codes: codes(SPLIT, FLAT) }, { index: 1, codes: codes(SPLIT, FLAT) }]);
  const { indices } = places;

  assert.deepEqual(places.take([{ index: 1, codes: codes(SPLIT, FLAT) }]), { isReplaced: false, isWhole: false, chunks: [], moves: [] });
  assert.deepEqual(places.take([{ index: 1, codes: codes(FLAT, FLAT) }]), { isReplaced: false, isWhole: false, chunks: [1], moves: [] });
  assert.deepEqual(trianglesOf(places, 0).map(([[patch]]) => patch), [0, 0, 1, 2, 3]);
  places.take([{ index: 1, codes: codes(FLAT, SPLIT) }]);

  assert.equal(places.indices, indices);
  assert.deepEqual(trianglesOf(places, 0).map(([[patch]]) => patch), [0, 0, 1, 2, 3, 3]);
  assert.deepEqual(areasOf(trianglesOf(places, 0)).reduce((sum, area) => sum + area), 4 * 4096 ** 2);
});

test('what is left of a slot holds no points, so that none are evaluated there', () => {
  const places = new PatchPlaces(adaptiveLayout(2));
  places.take([{ index: 0, codes: codes(SPLIT, FLAT) }, { index: 1, codes: codes(FOUR, FLAT) }]);
  places.take([{ index: 1, codes: codes(FLAT, FLAT) }]);

  const patches = [...places.places.filter((_, i) => i % 2 === 0)].slice(0, places.room);

  const second = places.firstPointOf(1);
  assert.ok(places.room - second > 18); // the points that were there before
  assert.deepEqual(patches.slice(second), [2, 2, 2, 3, 3, 3, ...Array<number>(places.room - second - 6).fill(0xffff_ffff)]);
});

test('sides of triangles are made anew where other points are joined, and else stay', () => {
  const places = new PatchPlaces(adaptiveLayout(2));
  const sides = new TriangleSides(new ShaderMaterial());
  const vertices = new BufferGeometry();
  const made = (): BufferAttribute => {
    sides.update(places, vertices);
    return sides.object.geometry.index!;
  };
  places.take([{ index: 0, codes: codes(FLAT, FLAT) }, { index: 1, codes: codes(SPLIT, FLAT) }]);
  const first = made();
  assert.equal(first.count, 2 * (3 + 3 + 5 + 3));

  places.take([{ index: 0, codes: codes(FLAT, FLAT) }]);
  assert.equal(made(), first);
  places.take([{ index: 1, codes: codes(FLAT, FLAT) }]);
  assert.equal(made().count, 2 * (3 + 3 + 3 + 3));
});

test('where a chunk outgrows its slot, all points move; those of other chunks stay the same', () => {
  const buffer = new PointBuffer();
  const layout = adaptiveLayout(3);
  const all = (middle: Uint16Array): { index: number; codes: Uint16Array }[] =>
    [{ index: 0, codes: codes(FLAT, SPLIT) }, { index: 1, codes: middle }, { index: 2, codes: codes(SPLIT, SPLIT) }];
  const write = (index: number, points: number): void => buffer.write(index, new Uint16Array(6 * points).fill(10 + index));
  const firsts = (): number[] => [0, 1, 2].map((chunk) => buffer.places.firstPointOf(chunk));
  const shown = (): number[][] => [7, 0, 8].map((points, chunk) =>
    Array.from({ length: points }, (_, n) => buffer.pointAt(buffer.places.firstPointOf(chunk) + n)[0]));
  const before = buffer.prepare(layout, false, all(codes(FLAT, FLAT)));
  [7, 6, 8].forEach((points, index) => write(index, points));
  const had = firsts();

  const after = buffer.prepare(layout, false, [{ index: 1, codes: codes(FOUR, FOUR) }]);
  write(1, 30);

  assert.notEqual(after, before);
  assert.ok(firsts()[2] > had[2], `${firsts()} after ${had}`);
  assert.deepEqual(shown(), [Array(7).fill(10), [], Array(8).fill(12)]);
  assert.equal(buffer.pointAt(buffer.places.firstPointOf(1) + 29)[0], 11);
  buffer.prepare(layout, false, [{ index: 0, codes: codes(FOUR, FLAT) }]);
  assert.deepEqual(shown()[2], Array(8).fill(12));
});

test('only the places and triangles of chunks with other patterns are sent', () => {
  const buffer = new PointBuffer();
  const layout = adaptiveLayout(3);
  const geometry = buffer.prepare(layout, false, [0, 1, 2].map((index) => ({ index, codes: codes(SPLIT, SPLIT) })));
  const [patchPlaces, indices] = [geometry.getAttribute('patchPlace') as BufferAttribute, geometry.index!];
  for (const attribute of [patchPlaces, indices]) attribute.onUploadCallback();
  const versions = (): number[] => [patchPlaces.version, indices.version];
  const before = versions();

  buffer.prepare(layout, false, [{ index: 1, codes: codes(SPLIT, SPLIT) }]);
  assert.deepEqual(versions(), before);
  buffer.prepare(layout, false, [{ index: 1, codes: codes(SPLIT, FLAT) }]);

  // A slot of 8 points has room for 2 more; one of 4 triangles for 3 indices more; one of 2 corner triangles for 3.
  assert.deepEqual(patchPlaces.updateRanges, [{ start: 20, count: 20 }]);
  assert.deepEqual(indices.updateRanges, [{ start: 15, count: 15 }, { start: 54, count: 9 }]);
  assert.ok(versions().every((version, i) => version > before[i]));
});

test('patterns that do not fit a chunk, or that no rule names, are refused', () => {
  const layout = adaptiveLayout(1);
  assert.equal(layout.pointsOf(0, codes(FOUR, SPLIT)), 19);
  assert.throws(() => layout.pointsOf(0, codes(FLAT)), /1 patterns for 2 patches/);
  assert.throws(() => layout.pointsOf(1, codes(FLAT, FLAT)), /chunk 1 of 1/);
  assert.throws(() => layout.pointsOf(0, codes(FLAT, 6)), /no pattern 6/);
  assert.throws(() => layout.pointsOf(0, codes(FLAT, 1024)), /no pattern 1024/);
});

test('a picture of what is broad is drawn with few triangles, but not with far fewer than that', () => {
  const drawn = (layout: TopologyLayout, patterns: number[][], triangles: number): number => {
    const buffer = new PointBuffer();
    const geometry = buffer.prepare(layout, false, patterns.map((list, index) => ({ index, codes: codes(...list) })));
    const before = { ...geometry.drawRange };
    let count = 0;
    buffer.drawCoarse(triangles, () => (count = geometry.drawRange.count / 3));
    assert.deepEqual(geometry.drawRange, before);
    return count;
  };
  const many = [[FOUR, FOUR], [FOUR, FOUR]]; // 64 triangles with room for 16 more, or 4 and 2 more

  assert.deepEqual([200, 50, 25, 100, 2].map((triangles) => drawn(uniformLayout(10), [], triangles)), [200, 50, 8, 50, 2]);
  assert.deepEqual([50, 12].map((triangles) => drawn(uniformLayout(7), [], triangles)), [98, 2]); // 98 are more than 8 times 12
  assert.equal(drawn(adaptiveLayout(2), many, 64), 80);
  assert.equal(drawn(adaptiveLayout(2), many, 20), 80); // 4 are less than a quarter of 20
  assert.equal(drawn(adaptiveLayout(2), many, 16), 6);
});
