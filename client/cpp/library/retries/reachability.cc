// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/retries/reachability.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"

namespace latticed::client {
namespace {

// A pause notices so late that it is stopped.
constexpr absl::Duration kSlice = absl::Milliseconds(50);

}  // namespace

Reachability::Reachability(absl::Duration retry_for, ReachabilityObserver observer)
    : retry_for_(retry_for), observer_(std::move(observer)) {}

void Reachability::Wait(grpc::Channel& channel, absl::Duration pause,
                        const std::function<bool()>& stopped) {
  const absl::Time end = absl::Now() + pause;
  const bool connected = channel.GetState(/*try_to_connect=*/true) == GRPC_CHANNEL_READY;
  for (absl::Time now = absl::Now(); now < end && !stopped(); now = absl::Now()) {
    const absl::Time until = std::min(end, now + kSlice);
    if (connected) {
      absl::SleepFor(until - now);
    } else if (channel.WaitForConnected(absl::ToChronoTime(until))) {
      return;
    }
  }
}

void Reachability::Lost(const absl::Status& error) {
  const MutexLock lock(&mutex_);
  if (!std::exchange(lost_, true) && observer_) observer_(error);
}

void Reachability::Found() {
  const MutexLock lock(&mutex_);
  if (std::exchange(lost_, false) && observer_) observer_(absl::OkStatus());
}

void Reachability::GaveUp() {
  const MutexLock lock(&mutex_);
  lost_ = false;
}

}  // namespace latticed::client
