// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface that the page evaluates by itself, of several lattices and of the one that is left of them.
import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { OrthographicCamera } from 'three';
import type { PatchLatticeSchema } from 'latticed/v1/event_pb';
import { Encoding, NormalMode } from 'latticed/v1/view_pb';
import { EvaluationWatch } from '@src/evaluation_watch';
import { Lattice } from '@src/lattice/lattice';
import { Summand } from '@src/lattice/lattice_sum';
import type { SettingsStore } from '@src/state/settings';
import type { Viewport } from '@src/viewport/viewport';
import { fromLattice } from '@src/wire/lattice_message';
import { randomPlan, type RandomPlan } from './support/random_plan';
import { SessionFixture, until } from './support/session_fixture';
import { silentGl } from './support/silent_gl';

const SEED = 11;

/** The lattice with all control points moved along x. */
function shifted(lattice: Lattice, by: number): Lattice {
  const moved = lattice.clone();
  for (let at = 0; at < moved.points.length; at += 3) moved.points[at]! += by;
  return moved;
}

/** A page that shows a scene of lattices, whose patches are those of a random plan. */
class Page {
  private draw = (): void => undefined;
  readonly watch: EvaluationWatch;
  readonly failures: Error[] = [];
  private evaluations = 0;
  measured = 0;

  private constructor(t: TestContext, readonly fixture: SessionFixture, readonly plan: RandomPlan) {
    const viewport = {
      gl: silentGl(), renderer: { resetState: () => undefined }, invalidate: () => undefined, pictureHeight: 100,
      canvas: { addEventListener: () => undefined, removeEventListener: () => undefined }, rig: { camera: new OrthographicCamera() },
      onDrawing: (draw: () => void) => {
        this.draw = draw;
        return () => undefined;
      },
    };
    this.watch = new EvaluationWatch(fixture.session, { value: { pixels: 1 } } as SettingsStore, viewport as unknown as Viewport, {
      changed: () => void ++this.evaluations,
      evaluated: () => void ++this.measured,
      failed: (error) => void this.failures.push(error),
    });
    t.after(() => this.watch.dispose());
  }

  static async open(t: TestContext): Promise<Page> {
    const fixture = await SessionFixture.live(t);
    const plan = await randomPlan(SEED, [2, 2, 2], NormalMode.FACET);
    fixture.server.plans.set('random', plan.parts);
    return new Page(t, fixture, plan);
  }

  state(lattice: Lattice, index: number, indexes: number[], revision: bigint, structureId = revision): void {
    const value = { lattice: fromLattice(lattice), structureId, revision, index, indexes };
    this.fixture.stream.event({ case: 'latticeState', value });
  }

  /** An update, of a sum if the scene has several lattices, with bounds of all edges if `isFirst`, and with own edits up to `applied`. */
  async update(
    revision: bigint, news?: MessageInitShape<typeof PatchLatticeSchema>['news'], isFirst = false, appliedSequence = 0n,
  ): Promise<void> {
    const { stream, session } = this.fixture;
    const { patches, edgeCount } = this.plan;
    const inside = patches.findIndex(({ isOutside }) => isOutside);
    if (isFirst) {
      stream.event({ case: 'topology', value: {
        topologyId: 'random', patchCount: BigInt(patches.length),
        chunkRuns: [inside, patches.length - inside].map((patchesPerChunk) => ({ chunkCount: 1, patchesPerChunk })) } });
    }
    stream.event({ case: 'updateBegin', value: { updateId: revision, view: { encoding: Encoding.PATCHES, normals: NormalMode.FACET } } });
    if (news) stream.event({ case: 'patchLattice', value: { news } });
    const chunks = [{ index: 0, chunkCount: 2, data: new Uint8Array(edgeCount) }];
    if (isFirst) stream.event({ case: 'chunks', value: { updateId: revision, topologyId: 'random', chunks } });
    let isIn = false;
    const end = session.on('update', () => (isIn = true));
    stream.event({ case: 'updateEnd', value: { updateId: revision, revision, appliedSequence } });
    await until(() => isIn);
    end();
  }

  /** Draws until something is evaluated. */
  async evaluated(): Promise<void> {
    const before = this.evaluations;
    await until(() => this.evaluates(before));
  }

  /** Draws a frame. Returns whether more has been evaluated than so many times. */
  evaluates(before = this.evaluations): boolean {
    this.draw();
    assert.deepEqual(this.failures, []);
    return this.evaluations > before;
  }

  /** The lowest x of the patches inside. */
  get lowest(): number {
    const lowest: number[] = [];
    this.fixture.surface.eachBox((box) => lowest.push(box.min.x));
    return lowest[0]!;
  }
}

for (const structure of ['the same structure', 'another structure']) {
  test(`when a sum of ${structure} ends, the surface is that of the lattice that is left`, async (t) => {
    console.log(`seed ${SEED}`);
    const page = await Page.open(t);
    const { lattice } = page.plan;
    const left = shifted(lattice, 3);
    page.state(left, 0, [0, 1], 1n);
    page.state(lattice, 1, [0, 1], 1n);
    const sum = structure === 'the same structure' ? lattice : lattice.clone();
    if (sum !== lattice) Object.assign(sum, { outside: { mode: 'linear', smooth: true, widths: [0, 0, 0, 0, 0, 0], steps: [] } });
    await page.update(1n, { case: 'state', value: { lattice: fromLattice(sum), structureId: 1n } }, true);
    await page.evaluated();
    const before = page.lowest;

    page.state(left, 0, [0], 2n);
    page.evaluates(); // the sum, as long as no update has come
    await page.update(2n);
    await page.evaluated();

    assert.ok(page.lowest > before + 1, `${page.lowest} after ${before}`);
  });
}

test('a lattice that is gone is not evaluated while an edit waits for its answer', async (t) => {
  const page = await Page.open(t);
  const { fixture: { session, stream }, plan: { lattice } } = page;
  page.state(lattice, 0, [0, 1], 1n);
  page.state(shifted(lattice, 3), 1, [0, 1], 1n);
  session.chooseLattice(1);
  await page.update(1n, { case: 'state', value: { lattice: fromLattice(shifted(lattice, 1)), structureId: 1n } }, true);
  await page.evaluated();
  session.apply({ kind: 'move', indices: Uint32Array.of(1), offset: [0.125, 0, 0] });
  const before = page.lowest;

  page.state(lattice, 0, [0], 2n);
  await page.update(2n);
  assert.ok(page.watch.isActive && !session.hasShownLattice);
  assert.ok(!page.evaluates());
  assert.equal(page.lowest, before);

  stream.event({ case: 'editResult', value: { sequence: stream.edits[0]!.sequence, revision: 2n, structureId: 2n } });
  assert.ok(session.hasShownLattice);
  await page.evaluated();
  assert.ok(page.lowest < before - 0.5);
});

/** A page that shows the sum of two lattices, of which the second is chosen. */
async function ofTwo(t: TestContext): Promise<Page> {
  const page = await Page.open(t);
  const { fixture: { session }, plan: { lattice } } = page;
  page.state(lattice, 0, [0, 1], 1n);
  page.state(shifted(lattice, 3), 1, [0, 1], 1n);
  session.chooseLattice(1);
  await page.update(1n, { case: 'state', value: { lattice: fromLattice(shifted(lattice, 1)), structureId: 1n } }, true);
  await page.evaluated();
  return page;
}

const near = (a: number, b: number): void => assert.ok(Math.abs(a - b) < 1e-4, `${a}, not ${b}`);

/** A move of all control points along x. */
function push({ fixture: { session } }: Page, by: number): void {
  session.apply({ kind: 'move', indices: Uint32Array.from({ length: session.lattice.count }, (_, i) => i), offset: [by, 0, 0] });
}

test('an own edit of one of several lattices is seen at once, and measured once; the sum that comes with its update takes its place', async (t) => {
  const page = await ofTwo(t);
  const { fixture: { session, stream }, plan: { lattice } } = page;
  const before = page.lowest;

  push(page, 0.5);
  assert.ok(page.evaluates());
  near(page.lowest, before + 0.5);
  assert.equal(page.measured, 1);
  push(page, 0.25);
  assert.ok(page.evaluates());
  near(page.lowest, before + 0.75);
  assert.equal(page.measured, 2);

  const [first] = stream.edits;
  stream.event({ case: 'editResult', value: { sequence: first!.sequence, revision: 2n, structureId: 1n } });
  page.state(shifted(lattice, 3.5), 1, [0, 1], 2n, 1n);
  await page.update(2n, { case: 'state', value: { lattice: fromLattice(shifted(lattice, 1.5)), structureId: 1n } }, false, first!.sequence);
  page.evaluates();
  near(page.lowest, before + 0.75); // the second edit is still ahead
  stream.event({ case: 'editResult', value: { sequence: stream.edits[1]!.sequence, revision: 3n, structureId: 1n } });
  page.state(shifted(lattice, 3.75), 1, [0, 1], 3n, 1n);
  assert.ok(session.areAllAt(3) && !session.areAllAt(2));
  await page.update(3n, { case: 'state', value: { lattice: fromLattice(shifted(lattice, 4)), structureId: 1n } }, false, stream.edits[1]!.sequence);
  await page.evaluated();
  near(page.lowest, before + 3); // what comes counts
  assert.equal(page.measured, 2);
});

test('edits between two frames are added to the sum once, and only the lattice that has moved is', async (t) => {
  const page = await ofTwo(t);
  const before = page.lowest;
  const { mock } = t.mock.method(Summand.prototype, 'displacements');
  for (const by of [0.5, 0.25, 0.125]) push(page, by);
  assert.equal(mock.callCount(), 0);
  assert.ok(page.evaluates());
  near(page.lowest, before + 0.875);
  assert.equal(mock.callCount(), 2, 'then and now');
  assert.equal(page.measured, 1);
  push(page, 0.125);
  page.evaluates();
  near(page.lowest, before + 1);
  assert.equal(mock.callCount(), 3);
});

test('a refused edit of one of several lattices is taken back at once', async (t) => {
  const page = await ofTwo(t);
  const { stream } = page.fixture;
  const before = page.lowest;
  push(page, 0.5);
  page.evaluates();
  near(page.lowest, before + 0.5);
  stream.event({ case: 'editResult', value: { sequence: stream.edits[0]!.sequence, status: { code: 9, message: 'no' } } });
  assert.ok(page.evaluates());
  near(page.lowest, before);
});

test('what others move of any of the lattices is seen with the own edit, before its update', async (t) => {
  const page = await ofTwo(t);
  const before = page.lowest;
  page.state(shifted(page.plan.lattice, 0.25), 0, [0, 1], 2n, 1n);
  assert.ok(!page.fixture.session.areAllAt(1));
  push(page, 0.5);
  page.evaluates();
  near(page.lowest, before + 0.75);
});

test('an edit of another structure than that of the sum waits for its update', async (t) => {
  const page = await ofTwo(t);
  const { plan: { lattice } } = page;
  const before = page.lowest;
  const other = new Lattice(lattice.frame, lattice.degree, lattice.size, lattice.knots.map((list) => list.map((x) => 2 * x)) as unknown as Lattice['knots'], lattice.points.slice());
  page.state(lattice, 0, [0, 1], 2n);
  page.state(other, 1, [0, 1], 2n);
  push(page, 0.5);
  page.evaluates();
  near(page.lowest, before);
  assert.equal(page.measured, 0);
});
