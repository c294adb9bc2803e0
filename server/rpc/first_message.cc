// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/first_message.h"

#include <utility>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {

void FirstMessage::Await(absl::Duration timeout, const char* what,
                         std::function<void(absl::Status)> late) {
  alarm_.Set(absl::ToChronoTime(absl::Now() + timeout), [state = state_, timeout, what,
                                                         late = std::move(late)](bool expired) {
    State awaited = State::kAwaited;
    if (!expired || !state->compare_exchange_strong(awaited, State::kLate)) return;
    late(error::FailedPrecondition(
        "STREAM_NOT_OPENED", fmt::format("the first message must be {}; none came within {}", what,
                                         absl::FormatDuration(timeout))));
  });
}

bool FirstMessage::Arrive() {
  State state = State::kAwaited;
  if (state_->compare_exchange_strong(state, State::kArrived)) {
    alarm_.Cancel();
    return true;
  }
  return state == State::kArrived;
}

}  // namespace latticed
