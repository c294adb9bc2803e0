// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From quantised integers to the symbols that a Draco stream codes. The prediction is DIFFERENCE: a point is predicted
// by the one before it, the first one by zero. These are the definitions; the vectorised functions in
// draco_symbols-inl.h give the same numbers.
//
//   position   d = value - previous, wrapped into [-floor(D / 2), floor((D - 1) / 2)] by adding or
//              subtracting D = most - least + 1 of the chunk's values; symbol 2d, or -2d - 1.
//              The first prediction, 0, counts as the least value
//   normal     value and prediction are taken about the centre of the octahedral square. Where the prediction lies
//              outside of the diamond, both are inverted (InvertDiamond). Both are turned by quarters until the
//              prediction is in the lower left. symbol = difference modulo 2^b - 1, for s and t
//
// Source   Draco bitstream 2.2, prediction transforms WRAP and NORMAL_OCTAHEDRON_CANONICALIZED
// Threads  pure functions, on host and device
#ifndef LATTICED_CORE_CODEC_DRACO_SYMBOLS_H_
#define LATTICED_CORE_CODEC_DRACO_SYMBOLS_H_

#include <cstdint>

#include "core/base/host_device.h"
#include "core/codec/octahedral.h"

namespace latticed {

// The symbol is below `span` = most - least + 1 <= 2^16, for values from least to most.
LATTICED_HD constexpr uint32_t PositionSymbol(uint32_t value, uint32_t previous, uint32_t span) {
  const bool falls = value < previous;
  const uint32_t distance = falls ? previous - value : value - previous;
  const bool wraps = distance > (falls ? span / 2 : (span - 1) / 2);
  return 2 * (wraps ? span - distance : distance) - (falls != wraps ? 1 : 0);
}

// The point of the octahedral square, about its centre, whose direction differs by the sign of the
// folded axis: inside and outside of the diamond change places.
LATTICED_HD constexpr OctahedralNormal InvertDiamond(OctahedralNormal n, int32_t centre) {
  const bool right = n.s > 0 || (n.s == 0 && n.t >= 0);
  const bool upper = n.t > 0 || (n.t == 0 && n.s >= 0);
  const int32_t corner_s = right ? centre : -centre, corner_t = upper ? centre : -centre;
  return right == upper ? OctahedralNormal{corner_s - n.t, corner_t - n.s}
                        : OctahedralNormal{corner_s + n.t, corner_t + n.s};
}

// Symbols of s and t, each at most OctahedralMax(bits), for values up to that. 6 <= bits <= 12.
LATTICED_HD constexpr OctahedralNormal NormalSymbols(OctahedralNormal value,
                                                     OctahedralNormal previous, int bits) {
  const int32_t centre = OctahedralMax(bits) / 2, modulus = OctahedralMax(bits) + 1;
  OctahedralNormal n{value.s - centre, value.t - centre};
  OctahedralNormal p{previous.s - centre, previous.t - centre};
  if ((p.s < 0 ? -p.s : p.s) + (p.t < 0 ? -p.t : p.t) > centre) {
    n = InvertDiamond(n, centre);
    p = InvertDiamond(p, centre);
  }
  // Turning is linear, so it suffices to turn the difference.
  const int32_t s = n.s - p.s, t = n.t - p.t;
  OctahedralNormal d{s, t};
  if (p.s > 0 && p.t >= 0) {
    d = {-s, -t};
  } else if (p.s >= 0 && p.t < 0) {
    d = {t, -s};
  } else if (p.s <= 0 && p.t > 0) {
    d = {-t, s};
  }
  return {d.s < 0 ? d.s + modulus : d.s, d.t < 0 ? d.t + modulus : d.t};
}

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_SYMBOLS_H_
