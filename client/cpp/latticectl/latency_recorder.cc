// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/latency_recorder.h"

#include <algorithm>
#include <cmath>

namespace latticed::client {
namespace {

// The share p of the values is this or less.
double NearestRank(const std::vector<double>& sorted, double p) {
  const double rank = std::ceil(p * static_cast<double>(sorted.size()));
  return sorted[static_cast<size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace

LatencySummary LatencyRecorder::Summarise() const {
  if (values_.empty()) return {};
  std::vector<double> sorted = values_;
  std::sort(sorted.begin(), sorted.end());
  return {.count = sorted.size(),
          .p50 = NearestRank(sorted, 0.5),
          .p90 = NearestRank(sorted, 0.9),
          .p99 = NearestRank(sorted, 0.99),
          .max = sorted.back()};
}

}  // namespace latticed::client
