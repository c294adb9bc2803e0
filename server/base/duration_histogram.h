// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How often something took how long, in the buckets that gRPC's own metrics have (gRFC A66), so
// that dashboards may add them up.
//
// Units    seconds; a bucket holds what took no longer than its bound
// Threads  safe, without locks: a reading may see one half of a concurrent observation
#ifndef LATTICED_SERVER_BASE_DURATION_HISTOGRAM_H_
#define LATTICED_SERVER_BASE_DURATION_HISTOGRAM_H_

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "absl/time/time.h"

namespace latticed {

class DurationHistogram {
 public:
  static constexpr std::array<double, 41> kBounds = {
      0,     0.00001, 0.00005, 0.0001, 0.0003, 0.0006, 0.0008, 0.001, 0.002, 0.003, 0.004,
      0.005, 0.006,   0.008,   0.01,   0.013,  0.016,  0.02,   0.025, 0.03,  0.04,  0.05,
      0.065, 0.08,    0.1,     0.13,   0.16,   0.2,    0.25,   0.3,   0.4,   0.5,   0.65,
      0.8,   1,       2,       5,      10,     20,     50,     100};

  // A negative duration, after a clock was set back, counts as 0.
  void Observe(absl::Duration duration) {
    const absl::Duration taken = std::max(duration, absl::ZeroDuration());
    const auto bound = std::ranges::lower_bound(kBounds, absl::ToDoubleSeconds(taken));
    ++counts_[static_cast<size_t>(bound - kBounds.begin())];
    nanoseconds_ += static_cast<uint64_t>(absl::ToInt64Nanoseconds(taken));
  }

  struct Reading {
    std::array<uint64_t, kBounds.size() + 1> counts{};  // the last counts what took longer
    double sum_seconds = 0;
  };
  Reading Read() const {
    Reading reading;
    for (size_t i = 0; i < counts_.size(); ++i) reading.counts[i] = counts_[i].load();
    reading.sum_seconds = static_cast<double>(nanoseconds_.load()) * 1e-9;
    return reading;
  }

 private:
  std::array<std::atomic<uint64_t>, kBounds.size() + 1> counts_{};
  std::atomic<uint64_t> nanoseconds_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_DURATION_HISTOGRAM_H_
