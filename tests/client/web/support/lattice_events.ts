// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a window does with one of several lattices, and what the server says of them.
import { fromLattice } from '@src/wire/lattice_message';
import { cubeLattice, type SessionFixture } from './session_fixture';

/** A move of control point 1 along x. */
export const move = (x: number) => ({ kind: 'move', indices: Uint32Array.of(1), offset: [x, 0, 0] }) as const;

/** The server has moved control point 1 of a lattice to this x. */
export function delta(fixture: SessionFixture, lattice: number, revision: bigint, x: number): void {
  fixture.stream.event({ case: 'latticeDelta', value: { structureId: 1n, revision, lattice, indices: [1], positions: [x, 0, 0] } });
}

/** The server has the lattices with these numbers; x of control point 1 is the number plus 2. */
export function states(fixture: SessionFixture, numbers: number[], revision: bigint, structureId: bigint): void {
  for (const index of numbers) {
    const lattice = cubeLattice();
    lattice.points[3] = index + 2;
    const value = { lattice: fromLattice(lattice), structureId, revision, index, indexes: numbers };
    fixture.stream.event({ case: 'latticeState', value });
  }
}

/** The server has applied the newest edit. */
export function accepted(fixture: SessionFixture, revision: bigint, structureId: bigint): void {
  const { sequence } = fixture.stream.edits.at(-1)!;
  fixture.stream.event({ case: 'editResult', value: { sequence, revision, structureId } });
}
