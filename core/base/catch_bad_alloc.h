// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns std::bad_alloc and std::length_error into a status. A thread calls this at its top: a
// request that is too large for the machine's memory is refused, and the others continue.
// Everything that it calls must be safe to leave at any allocation.
#ifndef LATTICED_CORE_BASE_CATCH_BAD_ALLOC_H_
#define LATTICED_CORE_BASE_CATCH_BAD_ALLOC_H_

#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "core/base/error.h"

namespace latticed {

// Returns the result of `work`, an absl::Status or a StatusOr, or kResourceExhausted with the name
// `what` where memory is short.
template <typename Work>
[[nodiscard]] auto CatchBadAlloc(std::string_view what, Work&& work) -> decltype(work()) {
  try {
    return std::forward<Work>(work)();
  } catch (const std::bad_alloc&) {
    return error::AllocationFailed(what);
  } catch (const std::length_error&) {
    return error::AllocationFailed(what);
  }
}

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_CATCH_BAD_ALLOC_H_
