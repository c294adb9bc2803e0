// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { NormalMode } from 'latticed/v1/view_pb';
import type { LatticedServer } from '../../wire/latticed_server';
import type { PatchPlan } from './patch_plan';
import { PlanReader } from './plan_reader';

/** The plans of a scene, each fetched once. */
export class PlanCache {
  private static readonly KEPT = 3;
  private readonly plans = new Map<string, Promise<PatchPlan>>();

  constructor(private readonly server: LatticedServer, private readonly scene: string) {}

  /** Rejects with an error in words. A plan that could not be fetched is asked for again by the next call. */
  plan(topologyId: string, normals: NormalMode): Promise<PatchPlan> {
    const key = `${topologyId} ${normals}`;
    const known = this.plans.get(key) ?? this.fetch(topologyId, normals);
    this.plans.delete(key);
    this.plans.set(key, known);
    known.catch(() => this.plans.delete(key));
    while (this.plans.size > PlanCache.KEPT) this.plans.delete(this.plans.keys().next().value!);
    return known;
  }

  private fetch(topologyId: string, normals: NormalMode): Promise<PatchPlan> {
    const call = { headers: { 'latticed-scene': this.scene } };
    return PlanReader.read(this.server.scenes.getPatchPlan({ scene: this.scene, topologyId, normals }, call));
  }
}
