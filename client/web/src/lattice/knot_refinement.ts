// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One axis of a lattice in the larger space of a sum of lattices. Each control point there is a blossom: the polynomial of the
// lattice at a knot span of the sum, taken at neighbouring knots of the sum (core/ffd/sum/knot_refinement.h).

/** Splines on one axis. The first and the last `degree + 1` knots are the ends. */
export interface AxisSpace {
  readonly degree: number;
  readonly knots: readonly number[];
}

/** A control point: those of the source from `first` on, and their weights; none where the source is 0. */
export interface RefinedPoint {
  readonly first: number;
  readonly weights: readonly number[];
}

const begin = ({ degree, knots }: AxisSpace): number => knots[degree]!;
const end = ({ degree, knots }: AxisSpace): number => knots[knots.length - 1 - degree]!;

/** The target has all knots of the source that are inside it, as often as needed, and the same degree or a higher one. */
export function refine(source: AxisSpace, target: AxisSpace): RefinedPoint[] {
  return Array.from({ length: target.knots.length - target.degree - 1 }, (_, point) => {
    const at = chosenSpan(source, target, point);
    if (at < begin(source) || at >= end(source)) return { first: 0, weights: [] };
    // Near ones first: equal spaces then give weights 0 and 1 exactly.
    const knots = target.knots.slice(point + 1, point + 1 + target.degree).sort((a, b) => Math.abs(a - at) - Math.abs(b - at));
    const span = source.knots.filter((knot) => knot <= at).length - 1;
    return { first: span - source.degree, weights: raisedBlossom(source, span, knots) };
  });
}

/** The beginning of a knot span in the support of a point: where the source is 0, or else the one nearest to the middle of its knots. */
function chosenSpan(source: AxisSpace, target: AxisSpace, point: number): number {
  const { degree, knots } = target;
  const middle = knots.slice(point + 1, point + 1 + degree).reduce((sum, knot) => sum + knot / degree, 0);
  let chosen = NaN, least = Infinity;
  for (let j = point; j <= point + degree; ++j) {
    const low = knots[j]!, high = knots[j + 1]!;
    if (!(low < high) || low < begin(target) || high > end(target)) continue;
    if (low < begin(source) || low >= end(source)) return low;
    const distance = Math.max(low - middle, middle - high, 0);
    if (distance < least) [chosen, least] = [low, distance];
  }
  return chosen;
}

/** The mean of the blossoms at all choices of source.degree of the arguments. */
function raisedBlossom(source: AxisSpace, span: number, args: readonly number[]): number[] {
  const choices = Array.from({ length: 1 << args.length }, (_, chosen) => args.filter((_arg, k) => (chosen >> k) & 1))
    .filter(({ length }) => length === source.degree)
    .map((some) => blossom(source, span, some));
  return choices[0]!.map((_, i) => choices.reduce((sum, one) => sum + one[i]!, 0) / choices.length);
}

/** The weights of control points span - degree to span in the blossom at `degree` arguments. */
function blossom({ knots }: AxisSpace, span: number, args: readonly number[]): number[] {
  let weights = [1];
  args.forEach((arg, n) => {
    const next = new Array<number>(n + 2).fill(0);
    for (let i = 1; i <= n + 1; ++i) {
      const low = knots[span + i - n - 1]!, high = knots[span + i]!;
      const a = (arg - low) / (high - low);
      next[i - 1]! += weights[i - 1]! * (1 - a);
      next[i]! += weights[i - 1]! * a;
    }
    weights = next;
  });
  return weights;
}
