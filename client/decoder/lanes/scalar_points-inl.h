// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// points-inl.h for machines without vectors: a chunk after the other.
// Included by lane_kernel.cc.
#ifndef LATTICED_CLIENT_DECODER_LANES_SCALAR_POINTS_INL_H_
#define LATTICED_CLIENT_DECODER_LANES_SCALAR_POINTS_INL_H_

#include <algorithm>
#include <cstdlib>

#include "client/decoder/lanes/lane_kernel.h"
#include "client/decoder/lanes/position_step.h"
#include "core/codec/draco_symbols.h"
#include "core/codec/octahedral.h"

namespace latticed::decoder::lane_kernel {

// The point that the symbols say, where `p` was predicted, inside of the diamond.
inline OctahedralNormal Corrected(OctahedralNormal p, uint32_t s_symbol, uint32_t t_symbol,
                                  int32_t centre) {
  const auto corrected = [centre](int32_t predicted, uint32_t symbol) {
    const int32_t sum = predicted + static_cast<int32_t>(symbol);
    return sum > centre ? sum - (2 * centre + 1) : sum;
  };
  if (p.s > 0 && p.t >= 0) return {-corrected(-p.s, s_symbol), -corrected(-p.t, t_symbol)};
  if (p.s >= 0 && p.t < 0) return {-corrected(-p.s, t_symbol), corrected(p.t, s_symbol)};
  if (p.s <= 0 && p.t > 0) return {corrected(p.s, t_symbol), -corrected(-p.t, s_symbol)};
  return {corrected(p.s, s_symbol), corrected(p.t, t_symbol)};
}

inline void WriteLane(PointLanes& lanes, size_t k) {
  const int32_t span = lanes.span[k] == 0 ? 1 << 16 : lanes.span[k];
  const int32_t centre = OctahedralMax(lanes.normal_bits) / 2;
  int32_t value[3] = {};
  OctahedralNormal normal;
  bool inverted =
      true;  // the first prediction is the square's corner, whose inversion is the centre
  for (size_t c = 0; c < 3; ++c) lanes.low[c][k] = 0xFFFF;
  for (uint32_t i = 0; i < lanes.points[k]; ++i) {
    uint16_t* const out = lanes.out[k] + 6 * size_t{i};
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t symbol = lanes.position_rows[(3 * size_t{i} + c) * kLanes + k];
      value[c] = NextPosition(value[c], symbol, span);
      out[c] = static_cast<uint16_t>(value[c] + lanes.least[k]);
      lanes.low[c][k] = std::min(lanes.low[c][k], out[c]);
      lanes.high[c][k] = std::max(lanes.high[c][k], out[c]);
    }
    out[3] = out[4] = out[5] = 0;
    if (lanes.normal_rows == nullptr) continue;
    const uint16_t* const symbols = lanes.normal_rows + 2 * size_t{i} * kLanes + k;
    const OctahedralNormal n = Corrected(normal, symbols[0], symbols[kLanes], centre);
    const OctahedralNormal inverse = InvertDiamond(n, centre), truth = inverted ? inverse : n;
    out[4] = static_cast<uint16_t>(truth.s + centre);
    out[5] = static_cast<uint16_t>(truth.t + centre);
    const int32_t distance = std::abs(n.s) + std::abs(n.t);
    normal = distance > centre ? inverse : n;
    // The border is its own inversion, and not outside.
    inverted = inverted ? distance < centre : distance > centre;
  }
}

}  // namespace latticed::decoder::lane_kernel

#endif  // LATTICED_CLIENT_DECODER_LANES_SCALAR_POINTS_INL_H_
