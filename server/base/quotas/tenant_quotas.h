// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What tenants use of what they may have, where this server counts it: edits, watchers, bytes. Time is an argument.
//
// A rate of n a second is a bucket of n that fills in a second. A message that goes out may be larger than what is in the
// bucket, which is then below zero: the next one waits until it is not.
//
// Errors   kResourceExhausted, reason QUOTA_EXCEEDED, with what is allowed, used, and asked for
// Threads  safe
#ifndef LATTICED_SERVER_BASE_QUOTAS_TENANT_QUOTAS_H_
#define LATTICED_SERVER_BASE_QUOTAS_TENANT_QUOTAS_H_

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/base/quotas/quota_table.h"

namespace latticed {

class TenantQuotas {
 public:
  // A watcher's place, which is free again when this is destroyed. The quotas outlive it.
  using Place = std::shared_ptr<const void>;

  void SetTable(QuotaTable table) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] QuotaTable table() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] TenantQuota Of(std::string_view tenant) const ABSL_LOCKS_EXCLUDED(mutex_);

  // The refusal where `used` and `asked` are together more than the quota, else OK. Counts it.
  [[nodiscard]] absl::Status Check(std::string_view tenant, QuotaKind kind, uint64_t used,
                                   uint64_t asked) ABSL_LOCKS_EXCLUDED(mutex_);
  // A batch of edits; the refusal has a time to try again.
  [[nodiscard]] absl::Status TakeEdit(std::string_view tenant, absl::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // A stream of messages begins, of a watcher or of something else, which has no place. The refusal where its first
  // message would have to wait for longer than kMostPatience, or the watchers are too many.
  static constexpr absl::Duration kMostPatience = absl::Seconds(1);
  [[nodiscard]] absl::StatusOr<Place> OpenStream(std::string_view tenant, bool watches,
                                                 absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  // A message of so many bytes goes out. Returns when the next one may, the infinite past without a quota.
  absl::Time TakeBytes(std::string_view tenant, uint64_t bytes, absl::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Of what this server counts, within the last second where it is a rate; 0 for scenes and mesh bytes.
  [[nodiscard]] uint64_t Used(std::string_view tenant, QuotaKind kind, absl::Time now) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] uint64_t Refused(std::string_view tenant, QuotaKind kind) const
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Bucket {
    double taken = 0;  // of a second's worth
    absl::Time last = absl::InfinitePast();
    // What is still taken at `now`.
    [[nodiscard]] double At(double rate, absl::Time now) const;
    void Take(double amount, double rate, absl::Time now);
  };
  struct Use {
    uint64_t watchers = 0;
    Bucket edits, bytes;
    std::array<uint64_t, kQuotaNames.size()> refused{};
  };
  absl::Status Refusal(Use& use, QuotaKind kind, uint64_t quota, uint64_t used, uint64_t asked,
                       absl::Duration wait) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status CheckBytes(std::string_view tenant, absl::Time now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Use& UseOf(std::string_view tenant) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void GiveBackWatcher(const std::string& tenant) ABSL_LOCKS_EXCLUDED(mutex_);

  mutable Mutex mutex_;
  QuotaTable table_ ABSL_GUARDED_BY(mutex_);
  // Tenants come from tokens, so there are not more of them than an operator or an identity provider makes.
  std::map<std::string, Use, std::less<>> uses_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_QUOTAS_TENANT_QUOTAS_H_
