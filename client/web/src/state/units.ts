// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The meaning of a scene's coordinates.
import type { Vec3 } from '../lattice/vec';

export type UpAxis = 'x' | 'y' | 'z';

export interface Units {
  /** Undefined: unknown; it is shown like z. */
  readonly up?: UpAxis | undefined;
  /** 0: unknown. */
  readonly metersPerUnit: number;
}

/** The facts that people want to know of a scene. */
export interface SceneFacts {
  /** May be empty. */
  readonly name: string;
  readonly units: Units;
}

export const UNKNOWN_FACTS: SceneFacts = { name: '', units: { metersPerUnit: 0 } };

const LENGTHS = [['km', 1000], ['m', 1], ['cm', 0.01], ['mm', 0.001]] as const;

/**
 * One length or those of a box in words, in metres or the like if the unit is known. `digits`: those that count. A length below
 * a millionth of the largest is a rounding error, shown as 0.
 */
export function lengthsInWords(lengths: readonly number[], { metersPerUnit }: Units, digits = 3): string {
  const largest = Math.max(...lengths);
  const [name, length] = LENGTHS.find(([, least]) => largest * metersPerUnit >= least) ?? LENGTHS[3];
  const scale = metersPerUnit > 0 ? metersPerUnit / length : 1;
  const shown = lengths.map((extent) => (extent < 1e-6 * largest ? 0 : extent * scale));
  const numbers = shown.map((extent) => Number(extent.toPrecision(digits)).toString()).join(' × ');
  return `${numbers} ${metersPerUnit > 0 ? name : 'units'}`;
}

/** A volume in the unit of length that suits its edge, such as "1.25 cm³". */
export function volumeInWords(volume: number, { metersPerUnit }: Units, digits = 6): string {
  const edge = Math.cbrt(Math.abs(volume));
  const [name, length] = LENGTHS.find(([, least]) => edge * metersPerUnit >= least) ?? LENGTHS[3];
  const scale = metersPerUnit > 0 ? metersPerUnit / length : 1;
  return `${Number((volume * scale ** 3).toPrecision(digits))} ${metersPerUnit > 0 ? `${name}³` : 'cubic units'}`;
}

/**
 * The world direction of a direction that is given for z up and the front towards -y, like Blender's. The axes change places in
 * turn for x up; for y up the front is towards +z, like glTF's.
 */
export function uprightDirection([x, y, z]: Vec3, up: UpAxis): Vec3 {
  if (up === 'y') return [x, z, -y];
  return up === 'x' ? [z, x, y] : [x, y, z];
}
