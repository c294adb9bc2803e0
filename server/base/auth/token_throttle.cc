// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth/token_throttle.h"

#include <algorithm>

namespace latticed {

absl::Duration TokenThrottle::NoteWrong(std::string_view address, absl::Time now) {
  constexpr int kDoublings = 10;  // 100 ms times 2^10 is above a minute
  const MutexLock lock(&mutex_);
  const bool full = entries_.size() >= kMostAddresses && !entries_.contains(address);
  Entry& entry = entries_[full ? "others" : std::string(address)];
  entry.last = now;
  if (now < entry.open) return entry.open - now;
  if (++entry.wrong > kFree) {
    const int doublings = std::min(entry.wrong - kFree - 1, kDoublings);
    entry.open = now + std::min(kFirst * (1 << doublings), kLongest);
  }
  return absl::ZeroDuration();
}

void TokenThrottle::Forget(absl::Time now) {
  const MutexLock lock(&mutex_);
  std::erase_if(entries_,
                [now](const auto& entry) { return now - entry.second.last > kForgotten; });
}

}  // namespace latticed
