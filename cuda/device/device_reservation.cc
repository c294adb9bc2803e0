// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device_reservation.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace latticed {

absl::StatusOr<DeviceReservation> DeviceReservation::Create(std::shared_ptr<DeviceMemory> memory,
                                                            std::string_view what, uint64_t bytes) {
  LATTICED_RETURN_IF_ERROR(memory->Reserve(what, bytes));
  return DeviceReservation(std::move(memory), what, bytes);
}

absl::StatusOr<DeviceReservation> DeviceReservation::Create(
    const std::shared_ptr<DeviceMemory>& memory, std::string_view what,
    absl::FunctionRef<uint64_t()> bytes) {
  for (;;) {
    const uint64_t asked = bytes();
    auto room = Create(memory, what, asked);
    if (room.ok() || bytes() == asked) return room;
  }
}

DeviceReservation::~DeviceReservation() {
  if (left_ > 0) memory_->GiveBack(left_);
}

absl::StatusOr<void*> DeviceReservation::Allocate(std::string_view purpose, size_t bytes,
                                                  cudaStream_t stream) {
  if (bytes > left_) {
    const uint64_t more = bytes - left_;
    if (auto s = memory_->Reserve(what_, more); !s.ok()) return OfAll(s, more, left_ + taken_);
    left_ += more;
  }
  auto data = memory_->AllocateReserved(purpose, bytes, left_, stream);
  if (!data.ok()) return OfAll(data.status(), 0, taken_);
  left_ -= bytes;
  taken_ += bytes;
  return data;
}

absl::Status DeviceReservation::OfAll(const absl::Status& status, uint64_t more,
                                      uint64_t freed) const {
  const error::Details details = error::DetailsOf(status);
  if (!absl::IsResourceExhausted(status) || details.asked_bytes == 0) return status;
  return error::OutOfDeviceMemory(what_, memory_->device(), left_ + taken_ + more,
                                  details.free_bytes + freed);
}

}  // namespace latticed
