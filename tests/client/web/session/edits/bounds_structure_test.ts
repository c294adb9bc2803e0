// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which structure of the lattice the bounds of edges are of, where states of the lattice come sooner than updates are taken in.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { TopologySchema } from 'latticed/v1/event_pb';
import { LatticeStateSchema } from 'latticed/v1/lattice_pb';
import { NormalMode } from 'latticed/v1/view_pb';
import { clampedUniformKnots, identityPoints, knotVectors } from '@src/lattice/identity';
import { Lattice } from '@src/lattice/lattice';
import { EdgeBounds } from '@src/patches/levels/edge_bounds';
import { LatticeSync } from '@src/session/edits/lattice_sync';
import { Listeners } from '@src/session/listeners';
import { TopologyLayout } from '@src/surface/topology_layout';
import { fromLattice } from '@src/wire/lattice_message';

function latticeOf(points: number): Lattice {
  const frame = { origin: [0, 0, 0], u: [1, 0, 0], v: [0, 1, 0], w: [0, 0, 1] } as const;
  const knots = knotVectors(() => clampedUniformKnots(2, points));
  const structure = { frame, degree: [2, 2, 2], size: [points, points, points], knots } as const;
  return new Lattice(frame, structure.degree, structure.size, knots, identityPoints(structure));
}

/** A session's lattice and the bounds of its surface. */
class Taken {
  readonly bounds = new EdgeBounds();
  private readonly sync = new LatticeSync(() => undefined, new Listeners());

  state(points: number, revision: bigint): void {
    this.sync.takeState(create(LatticeStateSchema, { lattice: fromLattice(latticeOf(points)), structureId: BigInt(points), revision }));
  }

  /** An update, with bounds in this layout if it is given. Returns the points along an axis of the structure of the bounds. */
  update(revision: bigint, id?: string): number | undefined {
    if (id !== undefined) {
      const layout = new TopologyLayout(create(TopologySchema, { topologyId: id, patchCount: 1n, chunkRuns: [{ chunkCount: 1, patchesPerChunk: 1 }] }));
      const run = { firstChunk: 0, chunkCount: 1, firstEdge: 0, bytes: Uint8Array.of(1, 2, 3) };
      this.bounds.take({ layout, normals: NormalMode.FACET, runs: [run] });
    }
    this.bounds.updated(this.sync.structureAt(revision));
    return this.bounds.structure?.size[0];
  }
}

test('bounds are of the structure that the lattice has at their revision', () => {
  const taken = new Taken();
  taken.state(3, 1n);
  assert.equal(taken.update(1n), undefined); // of a view with points
  assert.equal(taken.update(1n, 'three'), 3);
  taken.state(4, 2n);
  assert.equal(taken.update(2n, 'four'), 4);
  assert.equal(taken.update(3n), 4);
});

test('bounds that are taken in after the lattice has another structure are not taken for those of the new one', () => {
  const taken = new Taken();
  taken.state(3, 1n);
  taken.state(4, 2n);
  assert.equal(taken.update(1n, 'three'), undefined);
  assert.equal(taken.update(2n, 'four'), 4);
  taken.state(5, 3n);
  taken.state(4, 4n);
  assert.equal(taken.update(3n, 'five'), undefined);
  assert.equal(taken.update(4n, 'four'), 4);
  assert.equal(taken.update(5n, 'four'), 4);
});

test('bounds of a layout are of another structure once several lattices have become one', () => {
  const taken = new Taken();
  taken.state(3, 1n);
  taken.update(1n, 'shared');
  const sum = latticeOf(4);
  taken.bounds.updated(latticeOf(3), sum);
  assert.equal(taken.bounds.structure, sum);
  taken.bounds.updated(undefined);
  assert.equal(taken.bounds.structure, undefined);
  assert.equal(taken.update(2n), 3);
});
