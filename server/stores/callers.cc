// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/stores/callers.h"

#include <algorithm>
#include <limits>

#include "core/base/limits.h"
#include "server/base/address.h"

namespace latticed {
namespace {

MemoryAccountPtr Account(double share, uint64_t bytes) {
  const uint64_t most = share < 1 ? static_cast<uint64_t>(share * static_cast<double>(bytes))
                                  : std::numeric_limits<uint64_t>::max();
  return std::make_shared<MemoryAccount>(most);
}

}  // namespace

CallerAccount::CallerAccount(double share, const SharedBudgets& budgets)
    : memory(Account(share, budgets.memory)),
      requests(Account(share, budgets.requests)),
      replies(Account(share, budgets.replies)),
      share_(share) {}

size_t CallerAccount::ShareOf(size_t limit) const {
  if (!has_share()) return limit;
  return std::max<size_t>(1, static_cast<size_t>(share_ * static_cast<double>(limit)));
}

bool CallerAccount::TakeCall(absl::Time now) {
  if (!has_share()) return true;
  const MutexLock lock(&mutex_);
  const int64_t second = absl::ToUnixSeconds(now);
  if (second != second_) calls_ = 0;
  second_ = second;
  return ++calls_ <= limits::kMaxCallsPerSecond;
}

std::shared_ptr<CallerAccount> Callers::Of(const std::string& name, const std::string& address,
                                           bool is_forwarded) {
  const bool is_local = !is_forwarded && IsOfThisMachine(address);
  const bool shares = share_ < 1 && (!name.empty() || !is_local);
  std::string key = "name " + name;
  if (name.empty()) key = shares ? "network " + NetworkOf(IpOf(address)) : "";
  const MutexLock lock(&mutex_);
  std::shared_ptr<CallerAccount>& account = accounts_[key];
  if (account == nullptr) {
    account = std::make_shared<CallerAccount>(shares ? share_ : 1, budgets_);
  }
  return account;
}

void Callers::DropUnused() {
  const MutexLock lock(&mutex_);
  std::erase_if(accounts_, [](const auto& entry) {
    const CallerAccount& account = *entry.second;
    return entry.second.use_count() == 1 && account.memory.use_count() == 1 &&
           account.replies.use_count() == 1 && account.requests.use_count() == 1;
  });
}

}  // namespace latticed
