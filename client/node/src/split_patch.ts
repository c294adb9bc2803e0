// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Splits a patch by the levels of its edges: the rule of PatchPattern in event.proto, without its order of points.

/** The sum of a point's three whole numbers: they are its barycentrics times WHOLE. */
export const WHOLE = 4096;
export const MOST_LEVEL = 5;

export type Point = readonly [number, number, number];
type Triangle = readonly [Point, Point, Point];

export interface SplitPatch {
  points: Point[];
  triangles: number[];  // three indices of points each
}

const known = new Map<number, SplitPatch>();

/** The code names the levels of edges 0, 1, 2: level_0 + 8 level_1 + 64 level_2. */
export function splitPatch(code: number): SplitPatch {
  const found = known.get(code) ?? split([code & 7, code >> 3 & 7, code >> 6].map((level) => 4 ** level));
  known.set(code, found);
  return found;
}

function split(powers: number[]): SplitPatch {
  const weight = (p: Point, q: Point): number => {
    const d = [q[0] - p[0], q[1] - p[1], q[2] - p[2]] as const;
    return Math.abs(d[0] * d[1]) * powers[0]! + Math.abs(d[1] * d[2]) * powers[1]! + Math.abs(d[2] * d[0]) * powers[2]!;
  };
  const result: SplitPatch = { points: [], triangles: [] };
  const numbers = new Map<string, number>();
  const waiting: Triangle[] = [[[WHOLE, 0, 0], [0, WHOLE, 0], [0, 0, WHOLE]]];
  for (let corners = waiting.pop(); corners; corners = waiting.pop()) {
    const parts = partsOf(corners, weight);
    if (parts) waiting.push(...parts);
    else for (const point of corners) result.triangles.push(numberOf(point, numbers, result.points));
  }
  return result;
}

// What a triangle becomes; undefined if no side of it is split.
function partsOf(corners: Triangle, weight: (p: Point, q: Point) => number): Triangle[] | undefined {
  const cut = [0, 1, 2].map((i) => weight(corners[i]!, corners[(i + 1) % 3]!) > WHOLE * WHOLE);
  const count = cut.filter(Boolean).length;
  if (count === 0) return undefined;
  // The triangle is turned so that pq is the one side that is split, or the one that is not.
  const first = count === 3 ? 0 : cut.indexOf(count === 1);
  const [p, q, r] = [0, 1, 2].map((i) => corners[(first + i) % 3]!) as [Point, Point, Point];
  const pq = middle(p, q), qr = middle(q, r), rp = middle(r, p);
  if (count === 1) return [[p, pq, r], [pq, q, r]];
  if (count === 3) return [[p, pq, rp], [pq, q, qr], [rp, qr, r], [pq, qr, rp]];
  const fromP = weight(p, qr), fromQ = weight(q, rp);
  return fromP < fromQ || (fromP === fromQ && isAfter(p, q))
    ? [[rp, qr, r], [p, q, qr], [p, qr, rp]]
    : [[rp, qr, r], [p, q, rp], [q, qr, rp]];
}

function middle(p: Point, q: Point): Point {
  return [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2];
}

function isAfter(p: Point, q: Point): boolean {
  return p[0] !== q[0] ? p[0] > q[0] : p[1] > q[1];
}

function numberOf(point: Point, numbers: Map<string, number>, points: Point[]): number {
  const name = point.join();
  const number = numbers.get(name) ?? points.push(point) - 1;
  numbers.set(name, number);
  return number;
}
