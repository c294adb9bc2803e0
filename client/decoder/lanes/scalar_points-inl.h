// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// points-inl.h for machines without vectors: a chunk after the other.
// Included by lane_kernel.cc.
#ifndef LATTICED_CLIENT_DECODER_LANES_SCALAR_POINTS_INL_H_
#define LATTICED_CLIENT_DECODER_LANES_SCALAR_POINTS_INL_H_

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "client/decoder/lanes/lane_kernel.h"

namespace latticed::decoder::lane_kernel {

struct ScalarNormal {
  int32_t s = 0, t = 0;
  friend bool operator==(const ScalarNormal&, const ScalarNormal&) = default;
};

inline ScalarNormal Inverted(ScalarNormal n, int32_t centre) {
  const bool right = n.s > 0 || (n.s == 0 && n.t >= 0), upper = n.t > 0 || (n.t == 0 && n.s >= 0);
  const int32_t corner_s = right ? centre : -centre, corner_t = upper ? centre : -centre;
  return right == upper ? ScalarNormal{corner_s - n.t, corner_t - n.s}
                        : ScalarNormal{corner_s + n.t, corner_t + n.s};
}

// The point that the symbols say, where `p` was predicted, inside of the diamond.
inline ScalarNormal Corrected(ScalarNormal p, uint32_t s_symbol, uint32_t t_symbol,
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
  const int32_t span = lanes.span[k], centre = (1 << lanes.normal_bits) / 2 - 1;
  uint32_t value[3] = {};
  ScalarNormal normal;
  bool inverted =
      true;  // the first prediction is the corner of the square, whose inversion is the centre
  for (size_t c = 0; c < 3; ++c) lanes.low[c][k] = 0xFFFF;
  for (uint32_t i = 0; i < lanes.points[k]; ++i) {
    uint16_t* const out = lanes.out[k] + 6 * size_t{i};
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t symbol = lanes.position_rows[(3 * size_t{i} + c) * kLanes + k];
      const uint32_t sum = value[c] + ((symbol >> 1) ^ (0u - (symbol & 1)));
      const auto wrapped = static_cast<int32_t>(sum);
      value[c] = span == 0 ? sum & 0xFFFF
                           : static_cast<uint32_t>(wrapped < 0       ? wrapped + span
                                                   : wrapped >= span ? wrapped - span
                                                                     : wrapped);
      out[c] = static_cast<uint16_t>(value[c] + lanes.least[k]);
      lanes.low[c][k] = std::min(lanes.low[c][k], out[c]);
      lanes.high[c][k] = std::max(lanes.high[c][k], out[c]);
    }
    out[3] = out[4] = out[5] = 0;
    if (lanes.normal_rows == nullptr) continue;
    const uint16_t* const symbols = lanes.normal_rows + 2 * size_t{i} * kLanes + k;
    const ScalarNormal n = Corrected(normal, symbols[0], symbols[kLanes], centre);
    const ScalarNormal inverse = Inverted(n, centre), truth = inverted ? inverse : n;
    out[4] = static_cast<uint16_t>(truth.s + centre);
    out[5] = static_cast<uint16_t>(truth.t + centre);
    const int32_t distance = std::abs(n.s) + std::abs(n.t);
    normal = distance > centre ? inverse : n;
    inverted = inverted ? distance < centre
                        : distance > centre;  // the border is its own inversion, and not outside
  }
}

}  // namespace latticed::decoder::lane_kernel

#endif  // LATTICED_CLIENT_DECODER_LANES_SCALAR_POINTS_INL_H_
