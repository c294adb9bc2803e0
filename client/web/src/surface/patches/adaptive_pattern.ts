// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The pattern of a patch in a view with a tolerance, by the rule of PatchPattern in event.proto. The server sends patterns
// too. Made here, none must be remembered from one stream to the next.
import { cornersOf, packed, type PatchPattern } from './patch_pattern';

/** The sum of a point's three barycentrics. */
export const ADAPTIVE_WHOLE = 4096;

/** The largest level of an edge. */
export const MOST_LEVEL = 5;

const MOST_CODE = 1023;

/** Barycentrics times ADAPTIVE_WHOLE. */
type Point = readonly [number, number, number];
type Triangle = readonly [Point, Point, Point];

const made = new Map<number, PatchPattern>();

/** The pattern with this code (Chunk.levels); throws if there is none. It has two details: all points, and the corners. */
export function adaptivePattern(code: number): PatchPattern {
  const known = made.get(code);
  if (known !== undefined) return known;
  const levels = [0, 1, 2].map((edge) => (code >> (3 * edge)) & 7);
  if (code > MOST_CODE || levels.some((level) => level > MOST_LEVEL)) throw new Error(`there is no pattern ${code}`);
  const pattern = patternOf(new Splitting(levels, code >> 9 === 1).triangles, Math.max(...levels));
  made.set(code, pattern);
  return pattern;
}

/** Splits the triangle of a patch's corners until no side is split. */
class Splitting {
  readonly triangles: Triangle[] = [];

  constructor(private readonly levels: readonly number[], private readonly isSparse: boolean) {
    this.split([ADAPTIVE_WHOLE, 0, 0], [0, ADAPTIVE_WHOLE, 0], [0, 0, ADAPTIVE_WHOLE]);
  }

  /** At most 2 * 4096^2 * 4^5 < 2^53, so it is exact. */
  private weight(p: Point, q: Point): number {
    let sum = 0;
    for (let edge = 0; edge < 3; ++edge) {
      const next = (edge + 1) % 3;
      const product = (q[edge]! - p[edge]!) * (q[next]! - p[next]!);
      sum += (this.isSparse ? -product : Math.abs(product)) * 4 ** this.levels[edge]!;
    }
    return sum;
  }

  private isSplit(p: Point, q: Point): boolean {
    return this.weight(p, q) > ADAPTIVE_WHOLE ** 2;
  }

  private split(...corners: Triangle): void {
    const cut = [0, 1, 2].map((side) => this.isSplit(corners[side]!, corners[(side + 1) % 3]!));
    const count = cut.filter(Boolean).length;
    const first = count === 1 ? cut.indexOf(true) : count === 2 ? cut.indexOf(false) : 0;
    const [p, q, r] = [0, 1, 2].map((i) => corners[(first + i) % 3]!) as unknown as Triangle;
    const [pq, qr, rp] = [middle(p, q), middle(q, r), middle(r, p)];
    if (count === 0) {
      this.triangles.push([p, q, r]);
    } else if (count === 1) {
      this.split(p, pq, r);
      this.split(pq, q, r);
    } else if (count === 2) {
      this.split(rp, qr, r);
      this.splitQuadrilateral(p, q, qr, rp);
    } else {
      this.split(p, pq, rp);
      this.split(pq, q, qr);
      this.split(rp, qr, r);
      this.split(pq, qr, rp);
    }
  }

  private splitQuadrilateral(p: Point, q: Point, qr: Point, rp: Point): void {
    const [fromP, fromQ] = [this.weight(p, qr), this.weight(q, rp)];
    if (fromP < fromQ || (fromP === fromQ && isAfter(p, q))) {
      this.split(p, q, qr);
      this.split(p, qr, rp);
    } else {
      this.split(p, q, rp);
      this.split(q, qr, rp);
    }
  }
}

/** Puts points and triangles in the order of event.proto. */
function patternOf(triangles: readonly Triangle[], largestLevel: number): PatchPattern {
  const rowLength = ADAPTIVE_WHOLE / 2 ** largestLevel;
  const rowOf = ([, , i2]: Point): number => Math.floor(i2 / rowLength);
  const all = [...new Map(triangles.flat().map((point) => [keyOf(point), point])).values()];
  const rows = [...new Set(all.map(rowOf))].sort((a, b) => a - b);
  const order = new Map(rows.map((row, n) => [row, n])); // rows without points do not count
  all.sort((p, q) => {
    const row = order.get(rowOf(p))!;
    return row - order.get(rowOf(q))! || (row % 2 === 0 ? 1 : -1) * (p[1] - q[1] || p[2] - q[2]);
  });
  const points = Uint32Array.from(all, keyOf);
  const numberOf = new Map(Array.from(points, (entry, n) => [entry, n]));
  const sorted = triangles.map(fromLeast).sort((t, u) => compare(t[0], u[0]) || compare(u[1], t[1]));
  const fine = Uint16Array.from(sorted.flat(), (point) => numberOf.get(keyOf(point))!);
  const corners = cornersOf(points, ADAPTIVE_WHOLE);
  return { points, details: [fine, Uint16Array.from(corners)], corners };
}

function middle(p: Point, q: Point): Point {
  return [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2];
}

function keyOf([, i1, i2]: Point): number {
  return packed(i1, i2);
}

function isAfter(p: Point, q: Point): boolean {
  return p[0] !== q[0] ? p[0] > q[0] : p[1] > q[1]; // their sums are equal, so the third differs with the second
}

/** By (i_2, i_1). */
function compare(p: Point, q: Point): number {
  return p[2] - q[2] || p[1] - q[1];
}

/** The same triangle, from its least corner on. */
function fromLeast(triangle: Triangle): Triangle {
  const first = [0, 1, 2].reduce((least, i) => (compare(triangle[i]!, triangle[least]!) < 0 ? i : least), 0);
  return [0, 1, 2].map((i) => triangle[(first + i) % 3]!) as unknown as Triangle;
}
