// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { LatticeDelta } from 'latticed/v1/event_pb';
import type { LatticeState } from 'latticed/v1/lattice_pb';

/** The lattices of a scene as its stream has told them, without this window's unanswered edits. */
export class LatticeStates {
  private readonly states: LatticeState[] = [];

  get count(): number {
    return this.states.length;
  }

  get all(): readonly LatticeState[] {
    return this.states;
  }

  of(index: number): LatticeState | undefined {
    return this.states[index];
  }

  /** The scene is another one. */
  forget(): void {
    this.states.length = 0;
  }

  take(state: LatticeState): void {
    this.states[state.index] = state;
  }

  takeDelta(delta: LatticeDelta): void {
    const state = this.states[delta.lattice];
    if (state?.structureId !== delta.structureId) return;
    const { controlPoints } = state.lattice!;
    delta.indices.forEach((index, n) => {
      for (let k = 0; k < 3; ++k) controlPoints[3 * index + k] = delta.positions[3 * n + k]!;
    });
    state.strength = delta.strength ?? state.strength;
    state.revision = delta.revision;
  }
}
