// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from '../../lattice/vec';

/** The unit normal of the integers s and t, in double (view.proto, ENCODING_QUANTISED). */
export function octahedralNormal(s: number, t: number, bits: number): Vec3 {
  const most = 2 ** bits - 2;
  let y = (2 * s) / most - 1;
  let z = (2 * t) / most - 1;
  const x = 1 - Math.abs(y) - Math.abs(z);
  if (x < 0) {
    y += y < 0 ? -x : x;
    z += z < 0 ? -x : x;
  }
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}
