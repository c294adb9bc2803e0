// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/memory/memory_budget.h"

#include <algorithm>
#include <utility>

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
  if (budget_ != nullptr) {
    LATTICED_RETURN_IF_ERROR(budget_->Exchange(what, bytes_, bytes));
  }
  bytes_ = bytes;
  return absl::OkStatus();
}

void MemoryReservation::Release() {
  Resize("", 0).IgnoreError();  // less is always granted
  budget_.reset();
}

absl::StatusOr<MemoryReservation> MemoryBudget::Reserve(std::string_view what, uint64_t bytes) {
  LATTICED_RETURN_IF_ERROR(Exchange(what, 0, bytes));
  return MemoryReservation(shared_from_this(), bytes);
}

absl::Status MemoryBudget::Exchange(std::string_view what, uint64_t before, uint64_t after) {
  const std::scoped_lock lock(mutex_);
  return ExchangeLocked(what, before, after);
}

absl::Status MemoryBudget::ExchangeLocked(std::string_view what, uint64_t before, uint64_t after) {
  const uint64_t others = used_ - before;
  const uint64_t free = total_ - std::min(total_, others);
  if (after > before && after > free) return error::OutOfMemory(what, after, free);
  used_ = others + after;
  return absl::OkStatus();
}

absl::StatusOr<MemoryReservation> Reserve(const std::shared_ptr<MemoryBudget>& budget,
                                          std::string_view what, uint64_t bytes) {
  if (budget == nullptr) return MemoryReservation();
  return budget->Reserve(what, bytes);
}

absl::Status MemoryBudget::KeepAtLeast(std::string_view what, uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  if (bytes <= kept_) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(ExchangeLocked(what, kept_, bytes));
  kept_ = bytes;
  return absl::OkStatus();
}

uint64_t MemoryBudget::kept_bytes() const {
  const std::scoped_lock lock(mutex_);
  return kept_;
}

uint64_t MemoryBudget::used_bytes() const {
  const std::scoped_lock lock(mutex_);
  return used_;
}

}  // namespace latticed
