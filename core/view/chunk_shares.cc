// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/chunk_shares.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace latticed {

std::vector<size_t> ShareChunks(size_t chunks, uint64_t bytes_per_chunk,
                                std::span<const uint64_t> free_bytes) {
  const size_t devices = free_bytes.size(), equal = (chunks + devices - 1) / devices;
  std::vector<double> weights(free_bytes.begin(), free_bytes.end());
  const bool fits = std::ranges::min(free_bytes) >= equal * bytes_per_chunk;
  const double room = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (fits || room == 0) weights.assign(devices, 1);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<size_t> bounds{0};
  double before = 0;
  for (const double weight : weights) {
    before += weight;
    bounds.push_back(
        static_cast<size_t>(std::llround(static_cast<double>(chunks) * before / total)));
  }
  bounds.back() = chunks;
  return bounds;
}

}  // namespace latticed
