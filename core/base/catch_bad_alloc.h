// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where threads begin: a request too large for the machine's memory is refused, and the others go
// on. Everything below may let std::bad_alloc and std::length_error pass, so it must be safe to
// leave at any allocation.
#ifndef LATTICED_CORE_BASE_CATCH_BAD_ALLOC_H_
#define LATTICED_CORE_BASE_CATCH_BAD_ALLOC_H_

#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "core/base/error.h"

namespace latticed {

// What `work` returns, an absl::Status or a StatusOr; kResourceExhausted naming `what` where memory
// is short.
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
