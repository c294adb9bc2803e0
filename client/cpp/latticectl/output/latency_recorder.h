// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Records latencies and summarises them.
//
// Units    milliseconds; percentiles by nearest rank, 0 where nothing was recorded
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_LATENCY_RECORDER_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_LATENCY_RECORDER_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "absl/time/time.h"

namespace latticed::client {

struct LatencySummary {
  size_t count = 0;
  double p50 = 0, p90 = 0, p99 = 0, max = 0;
};

class LatencyRecorder {
 public:
  void Add(absl::Duration latency) { values_.push_back(absl::ToDoubleMilliseconds(latency)); }
  size_t count() const { return values_.size(); }
  LatencySummary Summarise() const {
    if (values_.empty()) return {};
    std::vector<double> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    const auto nearest_rank = [&sorted](double p) {  // >= the share p of the values
      const double rank = std::ceil(p * static_cast<double>(sorted.size()));
      return sorted[static_cast<size_t>(rank) - 1];
    };
    return {.count = sorted.size(),
            .p50 = nearest_rank(0.5),
            .p90 = nearest_rank(0.9),
            .p99 = nearest_rank(0.99),
            .max = sorted.back()};
  }

 private:
  std::vector<double> values_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_LATENCY_RECORDER_H_
