// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits of many scenes that are due evenly, and how long each takes to be durable. A slow medium does not slow them down.
#ifndef LATTICED_TESTS_BENCH_STORE_RECORD_LOAD_H_
#define LATTICED_TESTS_BENCH_STORE_RECORD_LOAD_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "absl/time/time.h"

namespace latticed::bench {

inline constexpr size_t kRecordBytes = 351;  // as an edit of ten points has
inline constexpr absl::Duration kRound = absl::Seconds(4);

struct Load {
  int scenes;
  int rate;  // of each, 1/s

  size_t edits() const {
    return static_cast<size_t>(absl::ToInt64Seconds(kRound)) * static_cast<size_t>(scenes * rate);
  }
};

struct Measured {
  double p50 = 0;  // ms, from due to durable
  double p99 = 0;
  double written = 0;  // bytes that this process made the kernel write, divided by bytes of records
};

// The mean number of processes that wanted to run in the last minute.
[[nodiscard]] std::string LoadOfMachine();
[[nodiscard]] std::string SceneId(int scene);
[[nodiscard]] std::string RecordOf(int scene, uint64_t lsn);

// Calls `append` for each edit when it is due, and gives it what to call when the edit is durable. Then calls `end`, which
// waits for all of them and ends the medium.
using Append = std::function<void(int scene, uint64_t lsn, std::function<void()> done)>;
[[nodiscard]] Measured Drive(const Load& load, const Append& append,
                             const std::function<void()>& end);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_RECORD_LOAD_H_
