// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reserves bytes of a device's budget for blocks that are needed together, before the first one is
// allocated. The destructor frees the bytes that no block took. Blocks belong to their buffers.
//
// Errors   kResourceExhausted with the bytes of all blocks and the bytes that are free for them,
//          also where the device and not the budget refuses a block; LeaveBehind excludes bytes
//          from both numbers
// Threads  one at a time
#ifndef LATTICED_CUDA_DEVICE_DEVICE_RESERVATION_H_
#define LATTICED_CUDA_DEVICE_DEVICE_RESERVATION_H_

#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

#include "absl/functional/function_ref.h"
#include "cuda/device/device_memory.h"

namespace latticed {

class DeviceReservation {
 public:
  // `what`: a literal that names all blocks together.
  [[nodiscard]] static absl::StatusOr<DeviceReservation> Create(
      std::shared_ptr<DeviceMemory> memory, std::string_view what, uint64_t bytes);
  // Reserves `bytes()`. Another thread may meanwhile allocate a part of them for all, such as
  // shared tables. If `bytes()` returns another number after a refusal, those blocks may have taken
  // the memory, and the reservation is tried again.
  [[nodiscard]] static absl::StatusOr<DeviceReservation> Create(
      const std::shared_ptr<DeviceMemory>& memory, std::string_view what,
      absl::FunctionRef<uint64_t()> bytes);
  ~DeviceReservation();
  DeviceReservation(const DeviceReservation&) = delete;  // gives back once
  DeviceReservation& operator=(const DeviceReservation&) = delete;
  DeviceReservation(DeviceReservation&& other) noexcept
      : memory_(std::move(other.memory_)),
        what_(other.what_),
        left_(std::exchange(other.left_, 0)),
        taken_(other.taken_) {}
  DeviceReservation& operator=(DeviceReservation&&) = delete;

  // As DeviceMemory::Allocate, from the reserved bytes. If too few are left, it reserves the rest.
  [[nodiscard]] absl::StatusOr<void*> Allocate(std::string_view purpose, size_t bytes,
                                               cudaStream_t stream);
  // Excludes `bytes` of the bytes taken from what a refusal of a later block would free: they
  // belong to something that stays, or they are free already.
  void LeaveBehind(uint64_t bytes) { taken_ -= bytes; }
  const std::shared_ptr<DeviceMemory>& memory() const { return memory_; }

 private:
  DeviceReservation(std::shared_ptr<DeviceMemory> memory, std::string_view what, uint64_t bytes)
      : memory_(std::move(memory)), what_(what), left_(bytes) {}
  // Turns the error of one block into an error of all blocks. They need `more` bytes than are reserved
  // or taken. `freed`: bytes that are free once all are refused and that `status` does not count.
  absl::Status OfAll(const absl::Status& status, uint64_t more, uint64_t freed) const;

  std::shared_ptr<DeviceMemory> memory_;
  std::string_view what_;
  uint64_t left_;
  uint64_t taken_ = 0;  // by blocks that are freed if a later one is refused
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_DEVICE_RESERVATION_H_
