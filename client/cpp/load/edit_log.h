// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edits of a scene by all of its editors: when each was due, and the revision that holds it.
//
// Threads  Add may be called by any thread; all else only when all editors are done
#ifndef LATTICED_CLIENT_CPP_LOAD_EDIT_LOG_H_
#define LATTICED_CLIENT_CPP_LOAD_EDIT_LOG_H_

#include <algorithm>
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

struct AppliedBatch {
  uint64_t revision = 0;
  absl::Duration apply_time;  // on the server, from its arrival until it was applied
};

class EditLog {
 public:
  // Adds an applied batch of one edit. `due` has the due times of the edit and of earlier edits that it
  // replaced before they were sent.
  void Add(const std::vector<absl::Time>& due, const v1::EditResult& result) {
    const MutexLock lock(&mutex_);
    for (const absl::Time time : due) edits_.push_back({time, result.revision()});
    batches_.push_back({result.revision(), absl::Microseconds(result.timings().queue_us()) +
                                               absl::Microseconds(result.timings().apply_us())});
  }

  // Sorts edits() and batches() by revision.
  void Sort() {
    std::ranges::stable_sort(edits_, {}, &TimedEdit::revision);
    std::ranges::sort(batches_, {}, &AppliedBatch::revision);
  }
  const std::vector<TimedEdit>& edits() const { return edits_; }
  const std::vector<AppliedBatch>& batches() const { return batches_; }

 private:
  Mutex mutex_;  // only needed while editors add
  std::vector<TimedEdit> edits_;
  std::vector<AppliedBatch> batches_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_EDIT_LOG_H_
