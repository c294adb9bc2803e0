// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What lattices are in their sum, against formula (1) of each of them.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { evaluate } from '@src/lattice/bspline';
import { AXES, domain, frameEdges, type Axes, type Axis, type LatticeStructure } from '@src/lattice/grid';
import { identityPoints } from '@src/lattice/identity';
import { Lattice, type LatticeFrame, type Outside, type Vec3 } from '@src/lattice/lattice';
import { Summand } from '@src/lattice/lattice_sum';
import { continuedLattice } from '@src/lattice/outside';
import { add, combine, coordinates, scale, sub } from '@src/lattice/vec';
import { SumAhead } from '@src/session/sum_ahead';
import { RandomNumbers } from '../support/random_numbers';

const SEED = 23;
const random = new RandomNumbers(SEED);
console.log(`seed ${SEED}`);

const WHOLE: LatticeFrame = { origin: [1, -2, 3], u: [4, 0.5, 0], v: [0, 3, 0.25], w: [-0.5, 0, 2] }; // not orthogonal

/** A part of the whole frame. */
function partOf(from: Vec3, to: Vec3, whole = WHOLE): LatticeFrame {
  const edges = frameEdges(whole);
  const [u, v, w] = AXES.map((axis) => scale(edges[axis], to[axis] - from[axis])) as [Vec3, Vec3, Vec3];
  return { origin: add(whole.origin, combine(edges, from)), u, v, w };
}

/** Random knots in the range 0 to `range`, of which one is repeated where there is room, and random moves. */
function shaken(frame: LatticeFrame, degree: Axes, outside?: Outside): Lattice {
  const size = degree.map((n, axis) => n + 2 + axis) as unknown as Axes;
  const range = 2;
  const knots = AXES.map((axis) => {
    const inner = Array.from({ length: size[axis] - degree[axis] - 1 }, () => range * random.next()).sort((a, b) => a - b);
    if (degree[axis] > 1 && inner.length > 1) inner[1] = inner[0]!;
    const ends = (x: number): number[] => new Array<number>(degree[axis] + 1).fill(x);
    return Float64Array.from([...ends(0), ...inner, ...ends(range)]);
  }) as unknown as Lattice['knots'];
  const points = identityPoints({ frame, degree, size, knots }).map((x) => x + 0.2 * (random.next() - 0.5));
  return new Lattice(frame, degree, size, knots, points, outside, 0.25 + 0.75 * random.next());
}

/** The smallest structure over the first lattice, as it is continued, that has all lattices in it: as the server's, in its parameter. */
function sumOf(lattices: readonly Lattice[]): LatticeStructure {
  const [first] = lattices as [Lattice];
  const whole = continuedLattice(first);
  const edges = frameEdges(first.frame);
  const spaces = AXES.map((axis) => {
    const degree = Math.max(...lattices.map((lattice) => lattice.degree[axis]));
    const [from, to] = domain(first, axis), [low, high] = domain(whole, axis);
    const near = 2 ** -40 * (high - low);
    const needed = new Map<number, number>();
    for (const { frame, knots, degree: own, size } of [whole, ...lattices.slice(1).map(continuedLattice)]) {
      const at = coordinates(edges, sub(frame.origin, first.frame.origin))[axis], edge = coordinates(edges, frameEdges(frame)[axis])[axis];
      const [begin, end] = [knots[axis][own[axis]]!, knots[axis][size[axis]]!];
      for (const knot of new Set(knots[axis])) {
        const isEnd = knot === begin || knot === end;
        const multiplicity = degree - own[axis] + (isEnd ? 1 : Array.from(knots[axis]).filter((other) => other === knot).length);
        const place = knots === whole.knots ? knot : from + ((to - from) * (at + (edge * (knot - begin)) / (end - begin)));
        const known = [...needed.keys()].find((other) => Math.abs(other - place) < near) ?? place;
        needed.set(known, Math.max(needed.get(known) ?? 0, multiplicity));
      }
    }
    const inner = [...needed].filter(([place]) => place > low + near && place < high - near).sort(([a], [b]) => a - b);
    const ends = (x: number): number[] => new Array<number>(degree + 1).fill(x);
    return { degree, knots: Float64Array.from([...ends(low), ...inner.flatMap(([place, times]) => new Array<number>(times).fill(place)), ...ends(high)]) };
  });
  const degree = spaces.map((space) => space.degree) as unknown as Axes;
  const knots = spaces.map((space) => space.knots) as unknown as Lattice['knots'];
  return { frame: whole.frame, degree, size: knots.map((list, axis) => list.length - degree[axis as Axis] - 1) as unknown as Axes, knots };
}

/** Where a lattice moves a point. */
function moved(lattice: Lattice, x: Vec3): Vec3 {
  const whole = continuedLattice(lattice);
  const place = coordinates(frameEdges(whole.frame), sub(x, whole.frame.origin));
  if (place.some((p) => p < 0 || p > 1)) return [0, 0, 0];
  return sub(evaluate(whole, AXES.map((axis) => {
    const [begin, end] = domain(whole, axis);
    return begin + place[axis] * (end - begin);
  }) as unknown as Vec3), x);
}

/**
 * How far the sum's moves of random points of the first lattice, as it is continued, are from what its lattices move them together:
 * as parts of the largest move of a control point, which is large where small knot spans go on linearly.
 */
function worstOf(lattices: readonly Lattice[]): number {
  const [first] = lattices as [Lattice];
  const structure = sumOf(lattices);
  const points = identityPoints(structure);
  let largest = 1;
  for (const lattice of lattices) {
    new Summand(lattice, structure, first).displacements(lattice).forEach((x, i) => {
      points[i]! += x;
      largest = Math.max(largest, Math.abs(x));
    });
  }
  const sum = new Lattice(structure.frame, structure.degree, structure.size, structure.knots, points);
  let worst = 0;
  for (let i = 0; i < 300; ++i) {
    const place = AXES.map((axis) => {
      const [begin, end] = domain(structure, axis);
      return begin + (0.001 + 0.998 * random.next()) * (end - begin);
    }) as unknown as Vec3;
    const inFirst = AXES.map((axis) => {
      const [begin, end] = domain(first, axis);
      return (place[axis] - begin) / (end - begin);
    }) as unknown as Vec3;
    const x = add(first.frame.origin, combine(frameEdges(first.frame), inFirst));
    const want = lattices.reduce<Vec3>((all, lattice) => add(all, moved(lattice, x)), [0, 0, 0]);
    worst = Math.max(worst, Math.hypot(...sub(sub(evaluate(sum, place), x), want)));
  }
  return worst / largest;
}

const FALLOFF: Outside = { mode: 'falloff', smooth: true, widths: [0.3, 0.5, 0.25, 0.5, 0.5, 0.4], steps: [] };
const LINEAR: Outside = { ...FALLOFF, mode: 'linear' };

for (const degrees of [[[2, 2, 2], [2, 2, 2]], [[1, 2, 3], [3, 2, 1]], [[3, 3, 3], [1, 1, 1]], [[2, 1, 3], [3, 3, 2]]] as const) {
  for (const smooth of [true, false]) {
    test(`degrees ${degrees.join(' and ')}, smooth ${smooth}: the moves add up, also of one that ends beyond the sum`, () => {
      const spot = shaken(partOf([0.25, 0.375, 0.25], [0.5, 0.625, 0.75]), degrees[1], { ...FALLOFF, smooth });
      const beyond = shaken(partOf([0.625, 0.75, 0.5], [1, 0.875, 1.25]), degrees[0], { ...FALLOFF, smooth });
      const worst = worstOf([shaken(WHOLE, degrees[0]), spot, beyond]);
      assert.ok(worst < 1e-13, `${worst}`);
    });
  }
  for (const outside of [FALLOFF, LINEAR]) {
    for (const far of [0, 1e5, 4e6]) {
      test(`degrees ${degrees.join(' and ')}: the moves add up ${far} from the origin, where the first has a ${outside.mode} outside`, () => {
        const whole = { ...WHOLE, origin: add(WHOLE.origin, [far, -far / 3, far / 7]) };
        const spot = shaken(partOf([0.25, 0.375, 0.25], [0.5, 0.625, 0.75], whole), degrees[1], FALLOFF);
        const worst = worstOf([shaken(whole, degrees[0], outside), spot]);
        assert.ok(worst < 1e-12 + 1e-14 * far, `${worst}`);
      });
    }
  }
}

test('a lattice is itself in a sum of its own structure, to the bit', () => {
  const lattice = shaken(WHOLE, [2, 3, 1]);
  lattice.strength = 1;
  const rest = identityPoints(lattice);
  assert.deepEqual(new Summand(lattice, lattice, lattice).displacements(lattice), lattice.points.map((x, i) => x - rest[i]!));
});

test('a sum is ahead by what has moved since it came, and elsewhere the same to the bit', () => {
  const lattices = [shaken(WHOLE, [2, 2, 2]), shaken(partOf([0.25, 0.25, 0.25], [0.5, 0.5, 0.5]), [1, 2, 2], FALLOFF)] as const;
  const structure = sumOf(lattices);
  const came = new Lattice(structure.frame, structure.degree, structure.size, structure.knots, identityPoints(structure).map((x) => x + random.next()));
  const numbered = (spot: Lattice): Map<number, Lattice> => new Map([[0, lattices[0]], [2, spot]]);
  const ahead = new SumAhead();
  assert.equal(ahead.of(numbered(lattices[1])), undefined, 'none has come');
  const shown = lattices[1].clone();
  ahead.take(came, numbered(shown));
  assert.equal(ahead.of(numbered(shown)), came);

  shown.points[3 * 7 + 1]! += 0.5; // in place, as edits
  const moved = ahead.of(numbered(shown))!;

  const spot = new Summand(shown, structure, lattices[0]);
  const now = spot.displacements(shown), before = spot.displacements(lattices[1]);
  let same = 0;
  moved.points.forEach((x, i) => {
    assert.ok(Math.abs(x - came.points[i]! - (now[i]! - before[i]!)) < 1e-14);
    if (now[i] === before[i]) assert.equal(x, came.points[i], `${++same}`);
  });
  assert.ok(same > 2 * came.count && same < 3 * came.count, 'only y moves, and not everywhere');
  shown.points[3 * 7 + 1] = lattices[1].points[3 * 7 + 1]!;
  assert.equal(ahead.of(numbered(shown)), came, 'it is back');
  shown.strength /= 2;
  assert.ok(ahead.of(numbered(shown)) !== came);
});

test('nothing is known of lattices that were not there when the sum came, or had another structure', () => {
  const lattices = [shaken(WHOLE, [2, 2, 2]), shaken(WHOLE, [2, 2, 2])] as const;
  const structure = sumOf(lattices);
  const came = new Lattice(structure.frame, structure.degree, structure.size, structure.knots, identityPoints(structure));
  const ahead = new SumAhead();
  ahead.take(came, new Map([[0, lattices[0]], [1, lattices[1]]]));
  const other = shaken(WHOLE, [2, 2, 2]); // other knots
  for (const numbered of [[[0, lattices[0]]], [[0, lattices[0]], [2, lattices[1]]], [[0, lattices[0]], [1, other]]] as const) {
    assert.equal(ahead.of(new Map<number, Lattice>(numbered)), undefined);
  }
  assert.equal(ahead.of(new Map([[0, lattices[0]], [1, lattices[1].clone()]])), came);
  ahead.take(came, new Map());
  for (const numbered of [[], [[0, lattices[0]], [1, lattices[1]]]] as const) assert.equal(ahead.of(new Map<number, Lattice>(numbered)), undefined);
  ahead.take(came, new Map([[0, lattices[0]], [1, lattices[1]]]));
  ahead.forget();
  assert.equal(ahead.of(new Map([[0, lattices[0]], [1, lattices[1]]])), undefined);
});
