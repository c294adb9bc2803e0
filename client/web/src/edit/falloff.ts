// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Soft selection: points near the selected ones take a part of their motion.

import { pointAt } from '../lattice/vec';

/** The weight by distance / radius, from 1 at a selected point to 0 at the radius; `constant` stays 1. */
export const FALLOFFS = {
  smooth: (x: number) => (1 - x) * (1 - x) * (1 + 2 * x),
  sphere: (x: number) => Math.sqrt(1 - x * x),
  root: (x: number) => Math.sqrt(1 - x),
  sharp: (x: number) => (1 - x) * (1 - x),
  linear: (x: number) => 1 - x,
  constant: () => 1,
} as const;

export type Falloff = keyof typeof FALLOFFS;

export interface SoftSelection {
  enabled: boolean;
  /** In world units, from the nearest selected point. */
  radius: number;
  falloff: Falloff;
}

export interface Weighted {
  index: number;
  weight: number;
  /** The selected point that it follows: itself, or the nearest one. */
  leader: number;
}

/** The selected points, with weight 1, then those within the radius that are not hidden, ascending. */
export function softWeights(
  points: ArrayLike<number>,
  selected: Uint32Array,
  soft: SoftSelection,
  isHidden: (index: number) => boolean,
): Weighted[] {
  const chosen = new Set(selected);
  const weighted: Weighted[] = Array.from(selected, (index) => ({ index, weight: 1, leader: index }));
  if (!soft.enabled || !(soft.radius > 0)) return weighted;

  for (let index = 0; index < points.length / 3; ++index) {
    if (chosen.has(index) || isHidden(index)) continue;
    const [leader, away] = nearest(points, index, selected);
    if (away < soft.radius) weighted.push({ index, weight: FALLOFFS[soft.falloff](away / soft.radius), leader });
  }
  return weighted;
}

function nearest(points: ArrayLike<number>, index: number, among: Uint32Array): [number, number] {
  const [x, y, z] = pointAt(points, index);
  let best = index;
  let least = Infinity; // squared; plain numbers, since this runs for every pair of points
  for (let i = 0; i < among.length; ++i) {
    const at = 3 * among[i];
    const dx = points[at] - x;
    const dy = points[at + 1] - y;
    const dz = points[at + 2] - z;
    const away = dx * dx + dy * dy + dz * dz;
    if (away < least) {
      least = away;
      best = among[i];
    }
  }
  return [best, Math.sqrt(least)];
}
