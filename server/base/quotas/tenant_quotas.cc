// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/quotas/tenant_quotas.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace latticed {
namespace {

// A quota of 0 a second is never filled again: a caller who waits so long asks again.
constexpr absl::Duration kLongestWait = absl::Minutes(1);
// Calls on several threads are out of order by less. A clock that was set back by more fills the buckets.
constexpr absl::Duration kClockStep = absl::Seconds(1);

absl::Duration TimeFor(double amount, double rate) {
  if (amount <= 0) return absl::ZeroDuration();
  return rate <= 0 ? kLongestWait : std::min(kLongestWait, absl::Seconds(amount / rate));
}

}  // namespace

double TenantQuotas::Bucket::At(double rate, absl::Time now) const {
  if (now < last - kClockStep) return 0;
  if (now <= last) return taken;
  return std::max(0.0, taken - absl::ToDoubleSeconds(now - last) * rate);
}

void TenantQuotas::Bucket::Take(double amount, double rate, absl::Time now) {
  taken = At(rate, now) + amount;
  last = now;
}

void TenantQuotas::SetTable(QuotaTable table) {
  const MutexLock lock(&mutex_);
  table_ = std::move(table);
}

QuotaTable TenantQuotas::table() const {
  const MutexLock lock(&mutex_);
  return table_;
}

TenantQuota TenantQuotas::Of(std::string_view tenant) const {
  const MutexLock lock(&mutex_);
  return table_.Of(tenant);
}

TenantQuotas::Use& TenantQuotas::UseOf(std::string_view tenant) {
  const auto found = uses_.find(tenant);
  return found != uses_.end() ? found->second : uses_[std::string(tenant)];
}

absl::Status TenantQuotas::Refusal(Use& use, QuotaKind kind, uint64_t quota, uint64_t used,
                                   uint64_t asked, absl::Duration wait) {
  ++use.refused[static_cast<size_t>(kind)];
  return error::QuotaExceeded(QuotaName(kind), quota, used, asked, wait);
}

absl::Status TenantQuotas::Check(std::string_view tenant, QuotaKind kind, uint64_t used,
                                 uint64_t asked) {
  const MutexLock lock(&mutex_);
  const auto most = table_.Of(tenant).Of(kind);
  if (!most.has_value() || (used <= *most && asked <= *most - used)) return absl::OkStatus();
  return Refusal(UseOf(tenant), kind, *most, used, asked, absl::ZeroDuration());
}

absl::Status TenantQuotas::TakeEdit(std::string_view tenant, absl::Time now) {
  const MutexLock lock(&mutex_);
  const auto most = table_.Of(tenant).Of(QuotaKind::kEditsPerSecond);
  if (!most.has_value()) return absl::OkStatus();
  Use& use = UseOf(tenant);
  const auto rate = static_cast<double>(*most);
  const double taken = use.edits.At(rate, now);
  if (taken + 1 <= rate) {
    use.edits.Take(1, rate, now);
    return absl::OkStatus();
  }
  return Refusal(use, QuotaKind::kEditsPerSecond, *most, static_cast<uint64_t>(taken), 1,
                 TimeFor(taken + 1 - rate, rate));
}

absl::StatusOr<TenantQuotas::Place> TenantQuotas::OpenStream(std::string_view tenant, bool watches,
                                                             absl::Time now) {
  {
    const MutexLock lock(&mutex_);
    LATTICED_RETURN_IF_ERROR(CheckBytes(tenant, now));
    if (!watches) return nullptr;
    Use& use = UseOf(tenant);
    const auto most = table_.Of(tenant).Of(QuotaKind::kWatchers);
    if (most.has_value() && use.watchers >= *most) {
      return Refusal(use, QuotaKind::kWatchers, *most, use.watchers, 1, absl::ZeroDuration());
    }
    ++use.watchers;
  }
  return Place(this, [this, name = std::string(tenant)](const void*) { GiveBackWatcher(name); });
}

void TenantQuotas::GiveBackWatcher(const std::string& tenant) {
  const MutexLock lock(&mutex_);
  --UseOf(tenant).watchers;
}

absl::Time TenantQuotas::TakeBytes(std::string_view tenant, uint64_t bytes, absl::Time now) {
  const MutexLock lock(&mutex_);
  const auto most = table_.Of(tenant).Of(QuotaKind::kBytesPerSecond);
  if (!most.has_value()) return absl::InfinitePast();
  const auto rate = static_cast<double>(*most);
  Bucket& bucket = UseOf(tenant).bytes;
  bucket.Take(static_cast<double>(bytes), rate, now);
  return now + TimeFor(bucket.taken - rate, rate);
}

absl::Status TenantQuotas::CheckBytes(std::string_view tenant, absl::Time now) {
  const auto most = table_.Of(tenant).Of(QuotaKind::kBytesPerSecond);
  if (!most.has_value()) return absl::OkStatus();
  Use& use = UseOf(tenant);
  const auto rate = static_cast<double>(*most);
  const double taken = use.bytes.At(rate, now);
  const absl::Duration wait = TimeFor(taken - rate, rate);
  if (wait <= kMostPatience) return absl::OkStatus();
  return Refusal(use, QuotaKind::kBytesPerSecond, *most, static_cast<uint64_t>(taken), 1, wait);
}

uint64_t TenantQuotas::Used(std::string_view tenant, QuotaKind kind, absl::Time now) const {
  const MutexLock lock(&mutex_);
  const auto found = uses_.find(tenant);
  if (found == uses_.end()) return 0;
  const Use& use = found->second;
  if (kind == QuotaKind::kWatchers) return use.watchers;
  const auto rate = static_cast<double>(table_.Of(tenant).Of(kind).value_or(0));
  if (kind == QuotaKind::kEditsPerSecond) return static_cast<uint64_t>(use.edits.At(rate, now));
  if (kind == QuotaKind::kBytesPerSecond) return static_cast<uint64_t>(use.bytes.At(rate, now));
  return 0;
}

uint64_t TenantQuotas::Refused(std::string_view tenant, QuotaKind kind) const {
  const MutexLock lock(&mutex_);
  const auto found = uses_.find(tenant);
  return found == uses_.end() ? 0 : found->second.refused[static_cast<size_t>(kind)];
}

}  // namespace latticed
