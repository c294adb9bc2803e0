// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs the work of several slices at once.
//
// Errors   kResourceExhausted where a thread cannot be made; what has begun is finished then
// Threads  waits for all of its threads
#ifndef LATTICED_CORE_VIEW_SPANNED_RUN_AT_ONCE_H_
#define LATTICED_CORE_VIEW_SPANNED_RUN_AT_ONCE_H_

#include <cstddef>
#include <span>
#include <system_error>
#include <thread>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/base/error.h"

namespace latticed {

// Calls work(s) for each of the slices, the first one on the caller's thread. `work` does not throw.
[[nodiscard]] inline absl::Status RunAtOnce(std::span<const size_t> slices,
                                            absl::FunctionRef<void(size_t slice)> work) {
  if (slices.empty()) return absl::OkStatus();
  try {
    std::vector<std::jthread> others;  // joined at the end
    for (const size_t slice : slices.subspan(1)) {
      others.emplace_back([work, slice] { work(slice); });
    }
    work(slices.front());
  } catch (const std::system_error&) {
    return error::AllocationFailed("a thread of a device");
  }
  return absl::OkStatus();
}

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_RUN_AT_ONCE_H_
