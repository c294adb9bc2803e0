// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/refusal_log.h"

#include <utility>

namespace latticed {

bool RefusalLog::Note(std::string_view address, std::string_view rpc, int code, absl::Time now) {
  const MutexLock lock(&mutex_);
  Kind kind(address, rpc, code);
  if (periods_.size() >= kMostKinds && !periods_.contains(kind)) std::get<0>(kind) = "others";
  Period& period =
      periods_.try_emplace(std::move(kind), Period{.end = now + kPeriod}).first->second;
  return ++period.refusals <= kFirst;
}

std::vector<RefusalLog::Sum> RefusalLog::TakeEnded(absl::Time now) {
  std::vector<Sum> sums;
  const MutexLock lock(&mutex_);
  std::erase_if(periods_, [&](const auto& entry) {
    const auto& [kind, period] = entry;
    if (now < period.end) return false;
    const auto& [address, rpc, code] = kind;
    if (period.refusals > kFirst) sums.push_back({address, rpc, code, period.refusals - kFirst});
    return true;
  });
  return sums;
}

}  // namespace latticed
