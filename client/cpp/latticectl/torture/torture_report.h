// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a torture has found and measured, and how it is printed.
//
// Threads  TortureCounts: safe; the others are plain data
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_REPORT_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_REPORT_H_

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/output/latency_recorder.h"
#include "core/base/mutex.h"

namespace latticed::client {

// Revisions, by what is wrong with them: scene_model.h.
struct Faults {
  uint64_t lost = 0, doubled = 0, gaps = 0, twice = 0, differing = 0;
  std::vector<std::string> what;  // a sentence for each scene that has faults

  void Add(const Faults& other);
};

// An answer that took longer is a pause.
inline constexpr absl::Duration kPause = absl::Milliseconds(200);

struct TortureReport {
  Faults faults;
  uint64_t acknowledged = 0;
  uint64_t refused = 0;  // edits that must be refused, as an undo of nothing
  uint64_t put_off = 0;  // edits that the server could not take
  uint64_t checks = 0;   // lattices that were compared
  uint64_t reconnections = 0;
  uint32_t seed = 0;
  absl::Duration duration;
  LatencySummary answers;     // from an edit to its acknowledgement
  LatencySummary pauses;      // those above kPause
  std::string longest_pause;  // the scene of the longest
};

[[nodiscard]] std::string TortureText(const TortureReport& report);
[[nodiscard]] nlohmann::json TortureJson(const TortureReport& report);

// What the threads of a torture count.
class TortureCounts {
 public:
  // `took`: from the time when the edit was due first, with all its tries.
  void Acknowledged(const std::string& scene, absl::Duration took);
  void Refused(bool put_off);
  void Checked();
  void Reconnected(int times);

  // All but faults, seed and duration.
  TortureReport Report() const;
  // "1,234 edits acknowledged, longest pause 12.3 ms, 0 reconnections"
  std::string Line() const;

 private:
  mutable Mutex mutex_;
  TortureReport report_ ABSL_GUARDED_BY(mutex_);
  LatencyRecorder answers_ ABSL_GUARDED_BY(mutex_), pauses_ ABSL_GUARDED_BY(mutex_);
  absl::Duration longest_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_REPORT_H_
