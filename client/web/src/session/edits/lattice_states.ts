// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { LatticeDelta } from 'latticed/v1/event_pb';
import type { LatticeState } from 'latticed/v1/lattice_pb';

/** The lattices of a scene as its stream has told them, without this window's unanswered edits. */
export class LatticeStates {
  private states: readonly LatticeState[] = []; // by number, ascending
  private named: readonly number[] = []; // by the newest state; empty: those that have come

  /** Their numbers, ascending: those of removed lattices are left out. */
  get numbers(): readonly number[] {
    return this.states.map(({ index }) => index);
  }

  /** The lowest number that no lattice has. */
  get free(): number {
    const gap = this.states.findIndex(({ index }, n) => index !== n);
    return gap < 0 ? this.states.length : gap;
  }

  /** The newest of theirs. */
  get revision(): bigint {
    return this.states.reduce((newest, { revision }) => (revision > newest ? revision : newest), 0n);
  }

  get all(): readonly LatticeState[] {
    return this.states;
  }

  /** Whether the scene has this lattice by the newest state. Its own may come later. */
  has(index: number): boolean {
    return this.named.length ? this.named.includes(index) : this.of(index) !== undefined;
  }

  of(index: number): LatticeState | undefined {
    return this.states.find((state) => state.index === index);
  }

  /** The scene is another one. */
  forget(): void {
    this.states = [];
    this.named = [];
  }

  take(state: LatticeState): void {
    this.named = state.indexes;
    const isLeft = ({ index }: LatticeState): boolean => !state.indexes.length || state.indexes.includes(index);
    const others = this.states.filter((other) => other.index !== state.index && isLeft(other));
    this.states = [...others, state].sort((a, b) => a.index - b.index);
  }

  /** Throws if the delta contradicts its lattice, which then stays. Returns false if a state of that lattice is to follow. */
  takeDelta(delta: LatticeDelta): boolean {
    const state = this.of(delta.lattice);
    if (state?.structureId !== delta.structureId) return false;
    const { controlPoints } = state.lattice!;
    check(delta, controlPoints.length);
    delta.indices.forEach((index, n) => {
      for (let k = 0; k < 3; ++k) controlPoints[3 * index + k] = delta.positions[3 * n + k]!;
    });
    state.strength = delta.strength ?? state.strength;
    state.revision = delta.revision;
    return true;
  }
}

function check({ indices, positions }: LatticeDelta, coordinates: number): void {
  if (positions.length !== 3 * indices.length) throw new Error('a lattice_delta must have three numbers per index');
  if (indices.some((index) => 3 * index >= coordinates)) throw new Error('a lattice_delta names a control point that does not exist');
}
