// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/memory/memory_budget.h"

#include <algorithm>
#include <utility>

#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace latticed {

MemoryReservation::MemoryReservation(std::shared_ptr<MemoryBudget> budget, uint64_t bytes)
    : budget_(std::move(budget)), bytes_(bytes) {}

MemoryReservation::MemoryReservation(MemoryReservation&& other) noexcept
    : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}

MemoryReservation& MemoryReservation::operator=(MemoryReservation&& other) noexcept {
  if (this == &other) return *this;
  Release();
  budget_ = std::exchange(other.budget_, nullptr);
  bytes_ = std::exchange(other.bytes_, 0);
  return *this;
}

absl::Status MemoryReservation::Resize(std::string_view what, uint64_t bytes) {
  if (budget_ == nullptr) return TryResize(what, bytes);
  return budget_->Admit([&] { return TryResize(what, bytes); });
}

absl::Status MemoryReservation::TryResize(std::string_view what, uint64_t bytes) {
  if (budget_ != nullptr) {
    LATTICED_RETURN_IF_ERROR(budget_->Exchange(what, bytes_, bytes));
  }
  bytes_ = bytes;
  return absl::OkStatus();
}

void MemoryReservation::Release() {
  TryResize("", 0).IgnoreError();  // a smaller reservation is always granted
  budget_.reset();
}

void MemoryBudget::SetEvictor(Evictor evictor) {
  const MutexLock lock(&mutex_);
  evictor_ = std::move(evictor);
}

absl::StatusOr<MemoryReservation> MemoryBudget::Reserve(std::string_view what, uint64_t bytes) {
  MemoryReservation reservation(shared_from_this(), 0);
  LATTICED_RETURN_IF_ERROR(reservation.Resize(what, bytes));
  return reservation;
}

absl::Status MemoryBudget::KeepAtLeast(std::string_view what, uint64_t bytes) {
  return Admit([&]() -> absl::Status {
    const MutexLock lock(&mutex_);
    if (bytes <= kept_) return absl::OkStatus();
    LATTICED_RETURN_IF_ERROR(ExchangeLocked(what, kept_, bytes));
    kept_ = bytes;
    return absl::OkStatus();
  });
}

std::optional<MemoryShortage> MemoryBudget::ShortageOf(const absl::Status& status) {
  if (!absl::IsResourceExhausted(status)) return std::nullopt;
  const error::Details details = error::DetailsOf(status);
  if (details.reason != "OUT_OF_MEMORY") return std::nullopt;
  MemoryShortage shortage{
      .bytes = details.asked_bytes - std::min(details.asked_bytes, details.free_bytes),
      .device = std::nullopt};
  const auto device = details.metadata.find(error::kDeviceKey);
  int number = 0;
  if (device != details.metadata.end() && absl::SimpleAtoi(device->second, &number)) {
    shortage.device = number;
  }
  return shortage;
}

bool MemoryBudget::Evict(const MemoryShortage& shortage) {
  Evictor evictor;
  {
    const MutexLock lock(&mutex_);
    evictor = evictor_;
  }
  return evictor != nullptr && evictor(shortage);
}

absl::Status MemoryBudget::Exchange(std::string_view what, uint64_t before, uint64_t after) {
  const MutexLock lock(&mutex_);
  return ExchangeLocked(what, before, after);
}

absl::Status MemoryBudget::ExchangeLocked(std::string_view what, uint64_t before, uint64_t after) {
  const uint64_t others = used_ - before;
  const uint64_t free = total_ - std::min(total_, others);
  if (after > before && after > free) return error::OutOfMemory(what, after, free);
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
