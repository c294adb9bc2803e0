// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How long the page waits for a server that does not answer.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { MeshSchema, MeshService } from 'latticed/v1/mesh_pb';
import type { PatchPlanPart } from 'latticed/v1/patches_pb';
import { SceneSchema, SceneService } from 'latticed/v1/scene_pb';
import { NormalMode } from 'latticed/v1/view_pb';
import { Services } from '@src/intake/services';
import { PlanCache } from '@src/patches/plan/plan_cache';
import { LatticedServer } from '@src/wire/latticed_server';
import { randomPlan } from '../support/random_plan';
import { until } from '../support/until';

const SILENCE_MS = 500; // parts come after 300: what inflates them may take long on a busy machine

test('calls with one answer have a deadline, a longer one where the server works on a whole mesh; streams have none', async () => {
  const deadlines: Record<string, number | undefined> = {};
  const server = new LatticedServer('http://test', undefined, createRouterTransport(({ service }) => {
    service(SceneService, {
      getScene: (_, { timeoutMs }) => ((deadlines.getScene = timeoutMs()), create(SceneSchema, { mesh: 'm' })),
      createScene: (_, { timeoutMs }) => ((deadlines.createScene = timeoutMs()), create(SceneSchema, {})),
      async *watch(_, { timeoutMs }) {
        deadlines.watch = timeoutMs();
      },
    });
    service(MeshService, { getMesh: (_, { timeoutMs }) => ((deadlines.getMesh = timeoutMs()), create(MeshSchema, {})) });
  }));
  const services = new Services(server);

  const facts = await services.describeScene('scene-1');
  await services.meshExtent(facts);
  await services.createScene('m', { lattice: { size: [2, 2, 2], degree: [1, 1, 1], padding: 0 }, view: {} });
  for await (const event of server.scenes.watch({})) assert.fail(event.event.case);

  const between = (least: number, most: number, ms = NaN): void => assert.ok(ms > least && ms <= most, `${ms} ms`);
  between(10_000, 15_000, deadlines.getScene);
  between(10_000, 15_000, deadlines.getMesh);
  between(200_000, 300_000, deadlines.createScene);
  assert.equal(deadlines.watch, undefined);
});

/** A server that sends a part of a plan every `pauseMs`, and stops after `most` parts without ending the call. */
async function planServer(pauseMs: number, most = Infinity, silenceMs = SILENCE_MS): Promise<{ cache: PlanCache; calls: { isEnded: boolean }[] }> {
  const { parts } = await randomPlan(3, [2, 2, 2], NormalMode.FACET);
  const calls: { isEnded: boolean }[] = [];
  const wait = (ms: number, signal: AbortSignal): Promise<void> => new Promise((resolve, reject) => {
    if (Number.isFinite(ms)) setTimeout(resolve, ms);
    signal.addEventListener('abort', () => reject(new Error('ended')));
  });
  async function* plan(_: unknown, { signal }: { signal: AbortSignal }): AsyncGenerator<PatchPlanPart> {
    const call = { isEnded: false };
    calls.push(call);
    signal.addEventListener('abort', () => (call.isEnded = true));
    for (const [i, part] of parts.entries()) {
      await wait(i < most ? pauseMs : Infinity, signal);
      yield part;
    }
  }
  const server = new LatticedServer('http://test', undefined, createRouterTransport(({ service }) => service(SceneService, { getPatchPlan: plan })));
  return { cache: new PlanCache(server, 'scene-1', silenceMs), calls };
}

test('a plan may take long while its parts come; a call that falls silent fails in time, and is made again when asked', async () => {
  const slow = await planServer(0.6 * SILENCE_MS);
  assert.ok((await slow.cache.plan('random', NormalMode.FACET)).patchCount > 10);

  const silent = await planServer(1, 2);
  const code = (error: unknown): boolean => ConnectError.from(error).code === Code.DeadlineExceeded;
  await assert.rejects(silent.cache.plan('random', NormalMode.FACET), code);
  assert.equal(silent.calls[0].isEnded, true);
  await assert.rejects(silent.cache.plan('random', NormalMode.FACET), code);
  assert.equal(silent.calls.length, 2);
});

test('a plan is no longer fetched once its scene is left, or three others have been asked for', async () => {
  const { cache, calls } = await planServer(Infinity, Infinity, 60_000);
  const codeOf = (id: string): Promise<unknown> => cache.plan(id, NormalMode.FACET).catch((error: unknown) => ConnectError.from(error).code);
  const first = codeOf('a');
  await until(() => calls.length === 1);
  const others = ['b', 'c', 'd'].map(codeOf);
  assert.equal(await first, Code.Canceled);
  await until(() => calls.length === 4);
  assert.deepEqual(calls.map(({ isEnded }) => isEnded), [true, false, false, false]);

  cache.close();

  assert.deepEqual(await Promise.all(others), [Code.Canceled, Code.Canceled, Code.Canceled]);
  await until(() => calls.every(({ isEnded }) => isEnded));
});
