// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Records latencies and summarises them.
//
// Units    milliseconds; percentiles by nearest rank, 0 where nothing was recorded
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_LATENCY_RECORDER_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_LATENCY_RECORDER_H_

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
  LatencySummary Summarise() const;

 private:
  std::vector<double> values_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_LATENCY_RECORDER_H_
