// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/memory/memory_budget.h"

#include <algorithm>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace latticed {

MemoryReservation::MemoryReservation(std::shared_ptr<MemoryBudget> budget, MemoryAccountPtr account)
    : budget_(std::move(budget)), account_(std::move(account)) {}

MemoryReservation::MemoryReservation(MemoryReservation&& other) noexcept
    : budget_(std::exchange(other.budget_, nullptr)),
      account_(std::exchange(other.account_, nullptr)),
      bytes_(std::exchange(other.bytes_, 0)) {}

MemoryReservation& MemoryReservation::operator=(MemoryReservation&& other) noexcept {
  if (this == &other) return *this;
  Release();
  budget_ = std::exchange(other.budget_, nullptr);
  account_ = std::exchange(other.account_, nullptr);
  bytes_ = std::exchange(other.bytes_, 0);
  return *this;
}

absl::Status MemoryReservation::Resize(std::string_view what, uint64_t bytes) {
  if (budget_ == nullptr) return TryResize(what, bytes);
  return budget_->Admit([&] { return TryResize(what, bytes); }, account_);
}

absl::Status MemoryReservation::TryResize(std::string_view what, uint64_t bytes) {
  if (budget_ != nullptr) {
    LATTICED_RETURN_IF_ERROR(budget_->Exchange(what, account_.get(), bytes_, bytes));
  }
  bytes_ = bytes;
  return absl::OkStatus();
}

void MemoryReservation::Release() {
  TryResize("", 0).IgnoreError();  // a smaller reservation is always granted
  budget_.reset();
  account_.reset();
}

void MemoryBudget::SetEvictor(Evictor evictor) {
  const MutexLock lock(&mutex_);
  evictor_ = std::move(evictor);
}

absl::StatusOr<MemoryReservation> MemoryBudget::Reserve(std::string_view what, uint64_t bytes,
                                                        MemoryAccountPtr account) {
  MemoryReservation reservation(shared_from_this(), std::move(account));
  LATTICED_RETURN_IF_ERROR(reservation.Resize(what, bytes));
  return reservation;
}

absl::Status MemoryBudget::KeepAtLeast(std::string_view what, uint64_t bytes) {
  return Admit([&]() -> absl::Status {
    const MutexLock lock(&mutex_);
    if (bytes <= kept_) return absl::OkStatus();
    LATTICED_RETURN_IF_ERROR(ExchangeLocked(what, nullptr, kept_, bytes));
    kept_ = bytes;
    return absl::OkStatus();
  });
}

std::optional<MemoryShortage> MemoryBudget::ShortageOf(const absl::Status& status,
                                                       const MemoryAccountPtr& account) {
  if (!absl::IsResourceExhausted(status)) return std::nullopt;
  const error::Details details = error::DetailsOf(status);
  if (details.reason != "OUT_OF_MEMORY") return std::nullopt;
  const bool of_share = details.metadata.contains(error::kShareKey);
  if (of_share && account == nullptr) return std::nullopt;  // whoever reserved has evicted already
  MemoryShortage shortage{
      .bytes = details.asked_bytes - std::min(details.asked_bytes, details.free_bytes),
      .device = std::nullopt,
      .account = of_share ? account : nullptr};
  const auto device = details.metadata.find(error::kDeviceKey);
  int number = 0;
  if (device != details.metadata.end() && absl::SimpleAtoi(device->second, &number)) {
    shortage.device = number;
  }
  return shortage;
}

bool MemoryBudget::Evict(const MemoryShortage& shortage) {
  // Looking at all scenes is dear, and a caller at its share may ask thousands of times a second.
  constexpr absl::Duration kFruitlessPause = absl::Milliseconds(100);
  MemoryAccount* const account = shortage.account.get();
  if (account != nullptr && absl::ToUnixNanos(absl::Now()) < account->nothing_until_ns_)
    return false;
  Evictor evictor;
  {
    const MutexLock lock(&mutex_);
    evictor = evictor_;
  }
  const bool evicted = evictor != nullptr && evictor(shortage);
  if (account != nullptr && !evicted) {
    account->nothing_until_ns_ = absl::ToUnixNanos(absl::Now() + kFruitlessPause);
  }
  return evicted;
}

absl::Status MemoryBudget::Exchange(std::string_view what, MemoryAccount* account, uint64_t before,
                                    uint64_t after) {
  const MutexLock lock(&mutex_);
  return ExchangeLocked(what, account, before, after);
}

absl::Status MemoryBudget::ExchangeLocked(std::string_view what, MemoryAccount* account,
                                          uint64_t before, uint64_t after) {
  const uint64_t others = used_ - before;
  const uint64_t free = total_ - std::min(total_, others);
  // The share comes first: for one who has used it up, nothing of others' is evicted.
  if (account != nullptr && after > before) {
    const uint64_t rest = account->used_ - before;
    const uint64_t share = account->most_ - std::min(account->most_, rest);
    if (after > share) return error::OutOfShare(what, after, share);
  }
  if (after > before && after > free) return error::OutOfMemory(what, after, free);
  if (account != nullptr) account->used_ = account->used_ - before + after;
  used_ = others + after;
  return absl::OkStatus();
}

uint64_t MemoryBudget::kept_bytes() const {
  const MutexLock lock(&mutex_);
  return kept_;
}

uint64_t MemoryBudget::used_bytes() const {
  const MutexLock lock(&mutex_);
  return used_;
}

}  // namespace latticed
