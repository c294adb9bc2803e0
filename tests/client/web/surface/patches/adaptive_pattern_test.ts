// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer's patterns against those that the server sends before their first use.
// Environment: LATTICED, the program.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { PatchPattern as Sent } from 'latticed/v1/event_pb';
import { Encoding } from 'latticed/v1/view_pb';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { Services } from '@src/intake/services';
import { adaptivePattern, ADAPTIVE_WHOLE } from '@src/surface/patches/adaptive_pattern';
import { unpacked } from '@src/surface/patches/patch_pattern';
import { LatticedServer } from '@src/wire/latticed_server';
import { ServerProcess } from '../../e2e/support/server_process';

/** Long and short triangles over a square: patches with edges of all levels. */
function slivers(): string {
  const xs = [0, 0.03, 0.1, 0.25, 0.6, 1.4, 3];
  const vertices = xs.flatMap((x) => xs.map((y) => `v ${x} ${y} ${0.1 * x * y}`));
  const at = (i: number, j: number): number => 1 + i * xs.length + j;
  const faces = xs.slice(1).flatMap((_, i) => xs.slice(1).flatMap((_, j) =>
    [`f ${at(i, j)} ${at(i + 1, j)} ${at(i + 1, j + 1)}`, `f ${at(i, j)} ${at(i + 1, j + 1)} ${at(i, j + 1)}`]));
  return [...vertices, ...faces].join('\n');
}

test('patterns made by the rule are those of the server, point by point and triangle by triangle', async (t) => {
  const process = await ServerProcess.start('.');
  t.after(() => process.kill());
  const server = new LatticedServer(process.origin);
  const services = new Services(server);
  const { id } = await services.upload(
    { name: 'slivers.obj', format: 'obj', content: new Blob([slivers()]) }, () => undefined, new AbortController().signal);
  const lattice = fitLattice({ min: [0, 0, -0.1], max: [3, 3, 1] }, { size: [5, 4, 3], degree: [2, 3, 1], padding: 0.02 });
  lattice.points.forEach((x, i) => (lattice.points[i] = x + 0.2 * Math.sin(5 * i * i + 1)));
  const scene = await services.createScene(id, { lattice, view: {} });

  const sent = new Map<number, Sent>();
  for (const tolerance of [0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.0005]) {
    const view = { segments: 32, tolerance, encoding: Encoding.RAW };
    for await (const { event } of server.scenes.getUpdate({ scene, view })) {
      if (event.case === 'patterns') for (const pattern of event.value.patterns) sent.set(pattern.code, pattern);
    }
  }

  const levels = new Set([...sent.keys()].flatMap((code) => [code & 7, (code >> 3) & 7, (code >> 6) & 7]));
  assert.deepEqual([...levels].sort(), [0, 1, 2, 3, 4, 5]);
  assert.ok(sent.size > 40 && [...sent.keys()].filter((code) => code >= 512).length > 10, `${sent.size} patterns`);
  for (const { code, denominator, points, triangles } of sent.values()) {
    const own = adaptivePattern(code);
    const scale = ADAPTIVE_WHOLE / denominator;
    const barycentrics = [...own.points].flatMap((entry) => {
      const [i1, i2] = unpacked(entry);
      return [ADAPTIVE_WHOLE - i1 - i2, i1, i2].map((i) => i / scale);
    });
    assert.deepEqual(barycentrics, points, `points of ${code}`);
    assert.deepEqual([...own.details[0]], triangles, `triangles of ${code}`);
    assert.deepEqual(own.corners.map((n) => unpacked(own.points[n])), [[0, 0], [ADAPTIVE_WHOLE, 0], [0, ADAPTIVE_WHOLE]]);
  }
});
