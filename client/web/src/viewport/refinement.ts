// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import { FINEST, planFor, type Plan } from './motion';

/** Moving: frames keep the budget. Resting: full detail. Settled: frames may be antialiased, which takes several. */
export type Pace = 'moving' | 'resting' | 'settled';

/** Draws coarsely while something moves, and finely at rest. */
export class Refinement {
  private static readonly REST_MS = 150; // after the last motion
  private static readonly JUDGED_BY = 3; // frames
  private static readonly SETTLED_MS = 400; // after the last change: a frame that has begun delays the next motion

  pace: Pace = 'settled';
  private moving = FINEST;
  private readonly recent = { plan: FINEST, ms: [] as number[] };
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** @param refined Called when a finer frame is due. */
  constructor(private readonly refined: () => void) {}

  get plan(): Plan {
    return this.pace === 'moving' ? this.moving : FINEST;
  }

  /** Something moves. */
  moved(): void {
    this.pace = 'moving';
    this.after(Refinement.REST_MS, () => this.rest());
  }

  /** The picture changes, but nothing moves. */
  changed(): void {
    if (this.pace !== 'moving') this.rest();
  }

  /**
   * A frame that was drawn by `plan` took `ms`. A motion gets coarser only; the next one begins by the last frames at rest.
   * One slow frame says nothing, since anything may delay it: a plan is judged by the median of its last three frames.
   */
  measured(plan: Plan, ms: number, triangles: readonly number[], pixels: number): void {
    if (plan !== this.plan) return;
    const { recent } = this;
    if (plan !== recent.plan) Object.assign(recent, { plan, ms: [] });
    recent.ms = [...recent.ms, ms].slice(-Refinement.JUDGED_BY);
    const sorted = [...recent.ms].sort((a, b) => a - b);
    if (sorted.length > 1) this.moving = planFor(plan, sorted[(sorted.length - 1) >> 1], triangles, pixels);
  }

  private rest(): void {
    const wasMoving = this.pace === 'moving';
    this.pace = 'resting';
    this.after(Refinement.SETTLED_MS, () => {
      this.pace = 'settled';
      this.refined();
    });
    if (wasMoving) this.refined();
  }

  private after(ms: number, then: () => void): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(then, ms);
  }
}
