// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reserves bytes of a device's budget for blocks that are needed together, before the first is
// allocated. The destructor gives back what no block took; blocks stay with their buffers.
//
// Errors   kResourceExhausted with the bytes of all blocks and those that are free for them, also where
//          the budget would hold a block and the device does not; what is left behind is of neither
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
  // Reserves what `bytes` returns. Others may allocate some of it meanwhile: where it returns
  // another number after a refusal, their blocks may have taken the memory, and the reservation is
  // tried again.
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

  // As DeviceMemory::Allocate, of the bytes reserved; more than are left is asked of the budget.
  [[nodiscard]] absl::StatusOr<void*> Allocate(std::string_view purpose, size_t bytes,
                                               cudaStream_t stream);
  // `bytes` of the bytes taken are not freed when a later block is refused: they belong to
  // something that stays, or they are free already.
  void LeaveBehind(uint64_t bytes) { taken_ -= bytes; }
  const std::shared_ptr<DeviceMemory>& memory() const { return memory_; }

 private:
  DeviceReservation(std::shared_ptr<DeviceMemory> memory, std::string_view what, uint64_t bytes)
      : memory_(std::move(memory)), what_(what), left_(bytes) {}
  // Turns the error of one block into that of all blocks, which need `more` bytes than are reserved
  // or taken. `freed`: bytes that are free once all are refused, and that `status` does not count.
  absl::Status OfAll(const absl::Status& status, uint64_t more, uint64_t freed) const;

  std::shared_ptr<DeviceMemory> memory_;
  std::string_view what_;
  uint64_t left_;
  uint64_t taken_ = 0;  // by blocks that go where a later one is refused
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_DEVICE_RESERVATION_H_
