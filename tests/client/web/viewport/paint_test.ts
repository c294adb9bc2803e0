// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The brush that paints vertex weights: which vertices a stroke reaches, what is shown, sent and taken back.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { LiveSession } from '@src/session/live_session';
import type { PatchOrigins } from '@src/surface/patch_source';
import { PaintedVertices } from '@src/surface/painted_vertices';
import { PaintDrag } from '@src/viewport/paint_drag';
import type { Occlusion } from '@src/viewport/occlusion';
import type { Viewport } from '@src/viewport/viewport';

/** One source triangle of vertices 2, 0, 1 in two patches, cut half-way between vertices 2 and 0. */
const ORIGINS: PatchOrigins = {
  corners: Uint32Array.of(0, 1, 2, 0, 1, 2),
  barycentrics: Float64Array.of(1, 0, 0, 0.5, 0.5, 0, 0, 0, 1, 0.5, 0.5, 0, 0, 1, 0, 0, 0, 1),
  vertices: Uint32Array.of(2, 0, 1, 2, 0, 1),
};

test('weights are those of the server, 1 where it has none, and linear over the source triangle', () => {
  const plain = new PaintedVertices(ORIGINS);
  assert.deepEqual([...plain.weights], [1, 1, 1]);
  const weighted = new PaintedVertices({ ...ORIGINS, weights: Float32Array.of(1, 0.5, 0, 1, 0.5, 0) });
  assert.deepEqual([...weighted.weights], [0.5, 0, 1]);
  const texels = (): number[] => [...(weighted.texture.image.data as Float32Array).subarray(0, 8)];
  assert.deepEqual(texels(), [1, 0.75, 0, 0, 0.75, 0.5, 0, 0]);
  weighted.weights[2] = 0;
  weighted.changed();
  assert.deepEqual(texels(), [0, 0.25, 0, 0, 0.25, 0.5, 0, 0]);
});

test('a server that does not tell vertices is said not to', () => {
  assert.throws(() => new PaintedVertices({ ...ORIGINS, vertices: undefined }), /does not tell the vertices/);
});

/** A stroke over vertices at the pixels (0, 0), (40, 0), (100, 0); the last is hidden. */
function strokeOf(brush = { radius: 20, strength: 1, weight: 0 }) {
  const painted = new PaintedVertices(ORIGINS);
  const sent: { indices: readonly number[]; weights: number[] }[] = [];
  const session = {
    surface: { painted, vertexPlaces: () => new Float64Array(9), object: undefined },
    setWeights: (indices: readonly number[], weights: Float32Array) => sent.push({ indices, weights: [...weights] }),
  } as unknown as LiveSession;
  const viewport = {
    projectAll: () => Float64Array.of(0, 0, 0, 40, 0, 0, 100, 0, 0), invalidate: () => undefined,
  } as unknown as Viewport;
  const occlusion = { visiblePoints: () => Uint8Array.of(1, 1, 0) } as unknown as Occlusion;
  return { painted, sent, begin: () => new PaintDrag(viewport, session, brush, [0, 0], occlusion) };
}

test('a press paints with a smooth falloff, and is sent once at its end', () => {
  const { painted, sent, begin } = strokeOf();
  const drag = begin();
  assert.deepEqual([...painted.weights], [0, 1, 1]);
  drag.move(10, 0); // two dabs at 5 and 10 pixels
  assert.deepEqual([...painted.weights], [0, 1, 1]);
  assert.deepEqual(sent, []);
  drag.end();
  assert.deepEqual(sent, [{ indices: [0], weights: [0] }]);
});

test('a stroke reaches what its path comes near, but nothing that the surface hides', () => {
  const { painted, sent, begin } = strokeOf({ radius: 20, strength: 0.5, weight: 0 });
  const drag = begin();
  assert.equal(painted.weights[0], 0.5);
  drag.move(100, 0);
  assert.ok(painted.weights[1]! < 0.2, `${painted.weights[1]}`);
  assert.equal(painted.weights[2], 1);
  drag.end();
  assert.deepEqual(sent[0]!.indices, [0, 1]);
});

test('a stroke that is cancelled or changes nothing sends nothing', () => {
  const { painted, sent, begin } = strokeOf();
  begin().cancel();
  assert.deepEqual([...painted.weights], [1, 1, 1]);
  const idle = strokeOf({ radius: 20, strength: 1, weight: 1 });
  idle.begin().end();
  assert.deepEqual([...sent, ...idle.sent], []);
});
