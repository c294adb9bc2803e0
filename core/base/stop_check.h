// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lets long work stop when nobody waits for its result any more.
//
//   StopPoll poll(stop);
//   for (…) {
//     LATTICED_RETURN_IF_ERROR(poll.Step());   // asks once in kStepsPerCheck steps
//     …
//   }
//
// Errors   kCancelled or kDeadlineExceeded, whichever the check gives
// Threads  a poll belongs to one thread and must not outlive the check
#ifndef LATTICED_CORE_BASE_STOP_CHECK_H_
#define LATTICED_CORE_BASE_STOP_CHECK_H_

#include <cstddef>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/base/status_macros.h"

namespace latticed {

// OK to go on, else the status that the work ends with.
using StopCheck = absl::FunctionRef<absl::Status()>;

inline absl::Status NeverStop() { return absl::OkStatus(); }

// Whether work ended because a check told it to.
inline bool IsStopped(const absl::Status& status) {
  return absl::IsCancelled(status) || absl::IsDeadlineExceeded(status);
}

class StopPoll {
 public:
  // This many steps take some milliseconds of planning. A check reads a clock and takes a lock.
  static constexpr size_t kStepsPerCheck = 4'096;

  explicit StopPoll(StopCheck check) : check_(check) {}

  // Call this before work on `steps` faces or patches. The first call asks, too.
  absl::Status Step(size_t steps = 1) {
    if (steps < left_) {
      left_ -= steps;
      return absl::OkStatus();
    }
    left_ = kStepsPerCheck;
    return check_();
  }

 private:
  StopCheck check_;
  size_t left_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_STOP_CHECK_H_
