// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of patches in double precision, from the words of patches.proto alone.
import { basisFunctions } from '@src/lattice/bspline';
import type { Lattice, Vec3 } from '@src/lattice/lattice';
import { add, cross, dot, normalized, scale, sub } from '@src/lattice/vec';
import { UNIT, worldOf, type RandomPlan } from './random_plan';

export interface ReferencePoint {
  /** World coordinates. */
  readonly position: Vec3;
  readonly normal: Vec3;
}

/** The point of a patch with integer weights of its corners. `isAttached`: the seam is. */
export function referencePoint(plan: RandomPlan, patch: number, weights: Vec3, isAttached: boolean): ReferencePoint {
  const { corners, isOutside } = plan.patches[patch];
  const sum = weights[0] + weights[1] + weights[2];
  const mixed = (values: readonly Vec3[]): Vec3 =>
    [0, 1, 2].map((axis) => values.reduce((all, value, k) => all + weights[k] * value[axis], 0) / sum) as unknown as Vec3;
  const rest = plan.restNormals[patch] ? mixed(plan.restNormals[patch]) : ([0, 0, 1] as const);
  const used = corners.filter((_, k) => weights[k] > 0);
  const inOutsideBox = (): Vec3 => {
    const [lower, upper] = plan.outside;
    const place = mixed(corners.map((corner, k) => (weights[k] > 0 ? plan.outsidePlaces.get(corner)! : [0, 0, 0])));
    return place.map((p, axis) => lower[axis] + ((upper[axis] - lower[axis]) * p) / UNIT) as unknown as Vec3;
  };
  if (isOutside) return { position: inOutsideBox(), normal: normalized(rest) };
  const places = corners.map((corner) => plan.places[corner]);
  const spans = [0, 1, 2].map((axis) => Math.max(0, Math.ceil(places.reduce((all, p) => all + p[axis], 0) / (3 * UNIT)) - 1));
  const moved = deformed(plan.lattice, spans, mixed(places));
  const [position, derivatives] = plan.weights.length > 0 ? weighed(plan, patch, weights, mixed(places), moved) : moved;
  const onSeam = used.length < 3 && used.every((corner) => plan.outsidePlaces.has(corner));
  return { position: isAttached && onSeam ? inOutsideBox() : position, normal: normalOf(plan.lattice, derivatives, rest) };
}

/** X + w (R - X) and its derivatives by the domain, from R and its own, with X the place at rest. */
function weighed(plan: RandomPlan, patch: number, weights: Vec3, place: Vec3, [moved, derivatives]: [Vec3, [Vec3, Vec3, Vec3]]): [Vec3, [Vec3, Vec3, Vec3]] {
  const { frame, knots, degree, size } = plan.lattice;
  const sum = weights[0] + weights[1] + weights[2];
  const weight = plan.patches[patch].corners.reduce((all, corner, k) => all + (weights[k] * plan.weights[corner]) / sum / UNIT, 0);
  const rest = worldOf(plan.lattice, place);
  const offset = sub(moved, rest);
  const edges = [frame.u, frame.v, frame.w].map((edge, axis) => scale(edge, 1 / (knots[axis][size[axis]] - knots[axis][degree[axis]])));
  const weighted = edges.map((edge, axis) => add(add(edge, scale(sub(derivatives[axis], edge), weight)),
    scale(offset, dot(plan.slopes[patch] ?? [0, 0, 0], edge)))) as [Vec3, Vec3, Vec3];
  return [add(rest, scale(offset, weight)), weighted];
}

/** The deformation and its derivatives by the domain, of the polynomial in these spans, at places. */
function deformed(lattice: Lattice, spans: readonly number[], place: Vec3): [Vec3, [Vec3, Vec3, Vec3]] {
  const axes = ([0, 1, 2] as const).map((axis) => {
    const knots = lattice.knots[axis];
    const degree = lattice.degree[axis];
    const intervals: number[] = [];
    for (let at = degree; at < lattice.size[axis]; ++at) if (knots[at + 1] > knots[at]) intervals.push(at);
    const interval = intervals[spans[axis]];
    const t = knots[interval] + ((knots[interval + 1] - knots[interval]) * (place[axis] - UNIT * spans[axis])) / UNIT;
    const values = basisFunctions(knots, degree, interval, t);
    // N_i' = n (N_(i, n-1) / (t_(i+n) - t_i) - N_(i+1, n-1) / (t_(i+n+1) - t_(i+1)))
    const lower = basisFunctions(knots, degree - 1, interval, t);
    const slopes = values.map((_, r) => {
      const i = interval - degree + r;
      const left = r > 0 ? lower[r - 1] / (knots[i + degree] - knots[i]) : 0;
      const right = r < degree ? lower[r] / (knots[i + degree + 1] - knots[i + 1]) : 0;
      return degree * (left - right);
    });
    return { first: interval - degree, values, slopes };
  });
  const sum = (kinds: readonly ('values' | 'slopes')[]): Vec3 => {
    let total: Vec3 = [0, 0, 0];
    const [u, v, w] = axes;
    w[kinds[2]].forEach((c, k) => v[kinds[1]].forEach((b, j) => u[kinds[0]].forEach((a, i) => {
      const index = u.first + i + lattice.size[0] * (v.first + j + lattice.size[1] * (w.first + k));
      total = add(total, scale([...lattice.points.subarray(3 * index, 3 * index + 3)] as unknown as Vec3, a * b * c));
    })));
    return total;
  };
  const derivative = (axis: number): Vec3 => sum([0, 1, 2].map((other) => (other === axis ? 'slopes' : 'values')));
  return [sum(['values', 'values', 'values']), [derivative(0), derivative(1), derivative(2)]];
}

function normalOf({ frame, knots, degree, size }: Lattice, [a, b, c]: readonly [Vec3, Vec3, Vec3], rest: Vec3): Vec3 {
  const edges = [frame.u, frame.v, frame.w];
  const sign = Math.sign(dot(edges[0], cross(edges[1], edges[2])));
  const h = edges.map((edge, axis) => (sign * dot(edge, rest)) / (knots[axis][size[axis]] - knots[axis][degree[axis]]));
  const direction = add(add(scale(cross(b, c), h[0]), scale(cross(c, a), h[1])), scale(cross(a, b), h[2]));
  return normalized(dot(direction, direction) > 0 ? direction : rest);
}
