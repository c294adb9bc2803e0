// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploads constant tables in one block. Their bytes are reserved together, so nothing is allocated
// where they do not all fit, and the error names the bytes of all.
//
//   | table | padding | table | padding | …      each begins at a multiple of 256 bytes
//
// Errors   those of device_buffer.h
// Threads  one at a time; Send enqueues and does not wait
#ifndef LATTICED_CUDA_DEVICE_TABLE_UPLOAD_H_
#define LATTICED_CUDA_DEVICE_TABLE_UPLOAD_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "cuda/device/device_buffer.h"
#include "cuda/device/device_reservation.h"

namespace latticed {

class TableUpload {
 public:
  // Adds a table. Send sets `to` to its place in the block, so `to` must live until then. It is
  // null for an empty table.
  template <typename T>
  void Add(std::vector<std::type_identity_t<T>> table, const T*& to) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kAlignment);
    to = nullptr;
    if (table.empty()) return;
    const auto elements = std::make_shared<const std::vector<T>>(std::move(table));
    const size_t at = PlaceAfter(size_);
    const size_t bytes = elements->size() * sizeof(T);
    size_ = at + bytes;
    const auto set_place = [&to](const uint8_t* place) { to = reinterpret_cast<const T*>(place); };
    tables_.push_back({at, bytes, {elements, elements->data()}, set_place});
  }

  // The bytes of a block with tables of these sizes, in this order.
  static size_t BlockBytes(std::initializer_list<size_t> tables) {
    size_t size = 0;
    for (const size_t bytes : tables) size = PlaceAfter(size) + bytes;
    return size;
  }

  // Returns the block. It must live as long as the tables are read.
  [[nodiscard]] absl::StatusOr<DeviceBuffer<uint8_t>> Send(std::shared_ptr<DeviceMemory> memory,
                                                           std::string_view purpose,
                                                           cudaStream_t stream) const {
    LATTICED_ASSIGN_OR_RETURN(auto room,
                              DeviceReservation::Create(std::move(memory), purpose, size_));
    return Send(room, purpose, stream);
  }
  // The same. Takes BlockBytes of the tables from the reservation.
  [[nodiscard]] absl::StatusOr<DeviceBuffer<uint8_t>> Send(DeviceReservation& from,
                                                           std::string_view purpose,
                                                           cudaStream_t stream) const {
    auto block = DeviceBuffer<uint8_t>::Create(from, purpose, size_, stream);
    if (!block.ok()) return block;
    for (const Table& table : tables_) {
      uint8_t* const place = block->data() + table.at;
      LATTICED_RETURN_IF_ERROR(CudaStatus(
          cudaMemcpyAsync(place, table.elements.get(), table.bytes, cudaMemcpyHostToDevice, stream),
          purpose));
      table.set_place(place);
    }
    return block;
  }

 private:
  static constexpr size_t kAlignment = 256;  // that of device memory blocks
  struct Table {
    size_t at;  // in the block
    size_t bytes;
    std::shared_ptr<const void> elements;
    std::function<void(const uint8_t* place)> set_place;
  };
  static size_t PlaceAfter(size_t size) {
    return (size + kAlignment - 1) / kAlignment * kAlignment;
  }

  std::vector<Table> tables_;
  size_t size_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_TABLE_UPLOAD_H_
