// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { NormalMode } from 'latticed/v1/view_pb';
import { withoutSilence } from '../../wire/deadlines';
import type { LatticedServer } from '../../wire/latticed_server';
import type { PatchPlan } from './patch_plan';
import { PlanReader } from './plan_reader';

interface Fetched {
  readonly plan: Promise<PatchPlan>;
  /** Ends the call, if it still runs. */
  readonly abort: AbortController;
}

/** The plans of a scene, each fetched once. */
export class PlanCache {
  private static readonly KEPT = 3;
  private readonly plans = new Map<string, Fetched>();

  /** @param silenceMs A call from which nothing comes for so long has failed; absent: the usual time. */
  constructor(private readonly server: LatticedServer, private readonly scene: string, private readonly silenceMs?: number) {}

  /** Rejects with an error in words. A plan that could not be fetched is asked for again by the next call. */
  plan(topologyId: string, normals: NormalMode): Promise<PatchPlan> {
    const key = `${topologyId} ${normals}`;
    const known = this.plans.get(key) ?? this.fetch(topologyId, normals);
    this.plans.delete(key);
    this.plans.set(key, known);
    known.plan.catch(() => this.plans.get(key) === known && this.plans.delete(key));
    while (this.plans.size > PlanCache.KEPT) this.drop(this.plans.keys().next().value!);
    return known.plan;
  }

  /** The scene is no longer shown: calls that still run end. */
  close(): void {
    for (const key of [...this.plans.keys()]) this.drop(key);
  }

  private drop(key: string): void {
    this.plans.get(key)?.abort.abort();
    this.plans.delete(key);
  }

  private fetch(topologyId: string, normals: NormalMode): Fetched {
    const abort = new AbortController();
    const call = { headers: { 'latticed-scene': this.scene }, signal: abort.signal };
    const parts = this.server.scenes.getPatchPlan({ scene: this.scene, topologyId, normals }, call);
    return { abort, plan: PlanReader.read(withoutSilence(parts, abort, this.silenceMs)) };
  }
}
