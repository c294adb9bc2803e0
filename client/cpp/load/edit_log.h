// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edits of a scene, by all of its editors: when each was due, and the revision that holds it.
//
// Threads  safe; edits() only when all editors are done
#ifndef LATTICED_CLIENT_CPP_LOAD_EDIT_LOG_H_
#define LATTICED_CLIENT_CPP_LOAD_EDIT_LOG_H_

#include <cstdint>
#include <vector>

#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "latticed/v1/edit.pb.h"

namespace latticed::client {

struct TimedEdit {
  absl::Time due;
  uint64_t revision = 0;
};

inline constexpr int kWarmUpEditor = -1;  // moves all points

// A batch that was applied: MakeLoadEdit with that step.
struct AppliedEdit {
  uint64_t revision = 0;
  int editor = 0;  // its number in the scene
  uint64_t step = 0;
  absl::Duration apply_time;  // on the server, from its arrival until it was applied
};

class EditLog {
 public:
  // Adds an applied edit. `due` also has the earlier edits that it replaced before they were sent.
  void Add(const std::vector<absl::Time>& due, int editor, uint64_t step,
           const v1::EditResult& result) {
    const MutexLock lock(&mutex_);
    for (const absl::Time time : due) edits_.push_back({time, result.revision()});
    replaced_ += due.size() - 1;
    applied_.push_back({result.revision(), editor, step,
                        absl::Microseconds(result.timings().queue_us()) +
                            absl::Microseconds(result.timings().apply_us())});
  }
  // Counts edits that were due, but not sent when the run was stopped.
  void AddUnsent(uint64_t edits) {
    const MutexLock lock(&mutex_);
    unsent_ += edits;
  }

  const std::vector<TimedEdit>& edits() const { return edits_; }
  uint64_t replaced() const { return replaced_; }
  uint64_t unsent() const { return unsent_; }
  const std::vector<AppliedEdit>& applied() const { return applied_; }

 private:
  Mutex mutex_;  // while editors add; not needed to read when all are done
  std::vector<TimedEdit> edits_;
  std::vector<AppliedEdit> applied_;
  uint64_t replaced_ = 0, unsent_ = 0;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_EDIT_LOG_H_
