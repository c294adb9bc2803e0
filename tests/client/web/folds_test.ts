// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds: refused edits, the watch of reports, and the drawn boxes.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { Code } from '@connectrpc/connect';
import { GesturePhase } from 'latticed/v1/edit_pb';
import { FoldReportSchema, FoldState } from 'latticed/v1/fold_pb';
import { FoldsWatch } from '@src/folds_watch';
import { fitLattice } from '@src/lattice/fitted_lattice';
import { LatticeRemarks } from '@src/lattice/lattice_remarks';
import { boxGrid, pointsOfBox } from '@src/lattice/box_grid';
import type { SessionEvents } from '@src/session/scene_session';
import { Listeners } from '@src/session/listeners';
import { toFolds, type Folds } from '@src/wire/fold_message';
import { refusal } from './support/fake_stream';
import { cubeLattice, SessionFixture, until } from './support/session_fixture';

const one = Uint32Array.of(1);
const move = (x: number) => ({ kind: 'move', indices: one, offset: [x, 0, 0] }) as const;
const FOLD = refusal(Code.FailedPrecondition, 'FOLD', 'the edit would fold', { box: '0 0 0', determinant: '-1' });

function refuse(fixture: SessionFixture, sequence: bigint): void {
  fixture.stream.event({ case: 'editResult', value: { sequence, status: FOLD } });
}

test('edits say whether folds are refused, from the switch on', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.session.apply(move(0.1));
  fixture.accept(fixture.stream.edits[0].sequence, 1n);
  fixture.session.refuseFolds = true;
  fixture.session.apply(move(0.1));

  assert.deepEqual(fixture.stream.edits.map(({ refuseFolds }) => refuseFolds), [false, true]);
});

test('a drag stops at its last good state, and is committed there', async (t) => {
  const fixture = await SessionFixture.live(t);
  const idle: (boolean | undefined)[] = [];
  fixture.session.on('refused', (_, isIdle) => idle.push(isIdle));
  fixture.session.refuseFolds = true;
  const drag = fixture.session.gesture();
  drag.update(move(0.25));
  fixture.accept(fixture.stream.edits[0].sequence, 1n);
  fixture.delta(1n, [1], [0.75, 0, 0]);
  drag.update(move(9));
  assert.equal(fixture.x(1), 9.5);
  refuse(fixture, fixture.stream.edits[1].sequence);
  assert.equal(fixture.x(1), 0.75);

  drag.commit(move(10));
  const commit = fixture.stream.edits[2];
  assert.equal(commit.gesturePhase, GesturePhase.COMMIT);
  refuse(fixture, commit.sequence);

  const [, , , bare] = fixture.stream.edits;
  assert.equal(bare.gestureId, commit.gestureId);
  assert.equal(bare.gesturePhase, GesturePhase.COMMIT);
  assert.equal(bare.edits.length, 0);
  fixture.accept(bare.sequence, 2n);
  assert.equal(fixture.x(1), 0.75);
  assert.ok(fixture.session.canUndo);
  assert.deepEqual(idle, [true, true]); // told, not shown as errors
  assert.match(fixture.said[0], /would fold/);
});

test('a lone edit that would fold is taken back', async (t) => {
  const fixture = await SessionFixture.live(t);
  fixture.session.refuseFolds = true;
  fixture.session.apply(move(9));
  refuse(fixture, fixture.stream.edits[0].sequence);

  assert.equal(fixture.x(1), 0.5);
  assert.equal(fixture.stream.edits.length, 1);
});

test('a report has the folded boxes, and counts the others', () => {
  const folds = toFolds(create(FoldReportSchema, {
    revision: 3n, structureId: 1n, boxes: 8n, folded: 2n, undecided: 1n,
    places: [
      { state: FoldState.FOLDED, box: { u: 0, v: 1, w: 2 }, determinant: -0.5 },
      { state: FoldState.FOLDED, box: { u: 1, v: 0, w: 2 }, determinant: -2 },
      { state: FoldState.UNDECIDED, box: { u: 0, v: 0, w: 0 } },
    ],
  }));

  assert.deepEqual(folds.places, [[1, 0, 2], [0, 1, 2]]); // the worst first
  assert.deepEqual([folds.boxes, folds.folded, folds.undecided, folds.certified], [8, 2, 1, false]);
});

test('one question at a time is asked, again after a change, and none after the end', async () => {
  const listeners = new Listeners<SessionEvents>();
  const answers: ((folds: Folds | Error) => void)[] = [];
  const shown: (Folds | undefined)[] = [];
  const watch = new FoldsWatch({
    on: (event, listener) => listeners.on(event, listener),
    certifyFolds: () => new Promise((resolve, reject) => {
      answers.push((folds) => (folds instanceof Error ? reject(folds) : resolve(folds)));
    }),
  }, (folds) => shown.push(folds), 1);
  const folds = (folded: number): Folds =>
    ({ revision: 0n, structureId: 1n, certified: folded === 0, boxes: 8, folded, undecided: 0, places: [] });

  await until(() => answers.length === 1);
  for (let i = 0; i < 3; ++i) listeners.emit('points', one, true);
  assert.equal(answers.length, 1);
  answers[0](folds(0));
  await until(() => answers.length === 2);
  answers[1](new Error('no connection'));
  await until(() => shown.length === 2);
  assert.deepEqual(shown.map((report) => report?.folded), [0, undefined]);
  listeners.emit('answered');
  await until(() => answers.length === 3);
  answers[2](folds(2));
  await until(() => shown.length === 3);
  assert.equal(shown[2]?.folded, 2);

  listeners.emit('points', one, true);
  watch.dispose();
  await new Promise((resolve) => setTimeout(resolve, 10));
  assert.equal(answers.length, 3);
});

test('a remark names the control points of the box that folds most', () => {
  const lattice = fitLattice({ min: [0, 0, 0], max: [1, 1, 1] }, { size: [5, 4, 4], degree: [3, 2, 1], padding: 0 });
  const remarks = new LatticeRemarks(lattice, undefined);
  const folds = { revision: 1n, structureId: 1n, certified: false, boxes: 12, folded: 1, undecided: 0, places: [[1, 0, 2]] } as const;

  assert.deepEqual(remarks.of(lattice, undefined), []);
  assert.deepEqual(remarks.of(lattice, { ...folds, places: [] }), []);
  const [remark] = remarks.of(lattice, folds);
  assert.equal(remark.kind, 'fold');
  assert.deepEqual(remark.points, pointsOfBox(lattice, [1, 0, 2]));
  assert.equal(remark.points.length, 4 * 3 * 2);
  assert.ok(remark.points.every((index) => index % 5 >= 1 && Math.floor(index / 5) % 4 < 3 && index >= 40), `${remark.points}`);
  assert.deepEqual(pointsOfBox(lattice, [2, 0, 0]), []); // of another lattice
});

test('an answer about the lattice before is not shown', async () => {
  const listeners = new Listeners<SessionEvents>();
  const shown: (Folds | undefined)[] = [];
  let answer: (folds: Folds | undefined) => void = () => undefined;
  let asked = 0;
  const watch = new FoldsWatch({
    on: (event, listener) => listeners.on(event, listener),
    certifyFolds: () => new Promise((resolve) => [answer, asked] = [resolve, asked + 1]),
  }, (folds) => shown.push(folds), 1);
  await until(() => asked === 1);
  listeners.emit('lattice', cubeLattice());
  answer({ revision: 0n, structureId: 1n, certified: true, boxes: 8, folded: 0, undecided: 0, places: [] });
  await until(() => asked === 2);
  watch.dispose();

  assert.deepEqual(shown, [undefined]);
});

test('a box has twelve edges and six faces, which follow the lattice', () => {
  const lattice = cubeLattice(); // one knot box
  const { edges, triangles } = boxGrid(lattice, [0, 0, 0], 2);
  assert.equal(edges.length, 12 * 2 * 2);
  assert.equal(triangles.length, 6 * 8 * 3);
  const corners = new Set(edges.map((point) => point.join()).filter((point) => /^[01],[01],[01]$/.test(point)));
  assert.equal(corners.size, 8);
  const lines = new Set(edges.map((_, i) => (i % 2 === 0 ? [edges[i], edges[i + 1]].map(String).sort().join(' ') : '')));
  assert.equal(lines.size, 25); // and ''

  lattice.points[0] = -1;
  assert.ok(boxGrid(lattice, [0, 0, 0], 2).edges.some(([x]) => x === -1));
  assert.deepEqual(boxGrid(lattice, [0, 0, 1], 2), { edges: [], triangles: [] });
});
