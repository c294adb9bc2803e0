// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/device_staging.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

// A batch takes a fraction of a millisecond over the bus, so the first one can be used early. Each of
// the two slots keeps at most this much pinned, or one chunk if that is larger.
constexpr size_t kBatchBytes = size_t{8} << 20;

absl::Status CopyToHost(uint8_t* to, const uint8_t* from, size_t bytes, cudaStream_t stream) {
  return CudaStatus(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream),
                    "the copy of vertices");
}

}  // namespace

size_t DeviceStaging::BatchEnd(std::span<const uint32_t> chunks, size_t first) const {
  size_t bytes = layout_.ChunkBytes(chunks[first]), last = first + 1;
  while (last < chunks.size() && bytes + layout_.ChunkBytes(chunks[last]) <= kBatchBytes) {
    bytes += layout_.ChunkBytes(chunks[last++]);
  }
  return last;
}

absl::Status DeviceStaging::Reserve(Slot& slot, size_t bytes, bool own_order) {
  if (!slot.copied.has_value()) {
    LATTICED_ASSIGN_OR_RETURN(auto event, CudaEvent::Create());
    slot.copied.emplace(std::move(event));
  }
  if (slot.pinned.size() < bytes) {
    LATTICED_ASSIGN_OR_RETURN(slot.pinned, context_->pinned().Borrow(bytes));
  }
  if (!own_order || slot.wire.size() >= bytes) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(
      auto wire, DeviceBuffer<uint8_t>::Create(context_->memory(), "staging", slot.pinned.size(),
                                               lane_->stream().get()));
  slot.wire = std::move(wire);
  return absl::OkStatus();
}

absl::Status DeviceStaging::Copy(Slot& slot, CudaVertexKernel& kernel,
                                 DeviceSpan<const uint8_t> vertices,
                                 std::span<const uint32_t> chunks, Batch& batch) {
  const bool own_order = kernel.OwnOrderBytes() > 0;
  const cudaStream_t stream = lane_->stream().get();
  size_t total = 0;
  for (uint32_t chunk : chunks) total += layout_.ChunkBytes(chunk);
  LATTICED_RETURN_IF_ERROR(Reserve(slot, total, own_order));
  batch.bytes.clear();
  size_t at = 0, run = 0;  // offsets of this chunk and of its run of neighbours
  for (size_t i = 0; i < chunks.size(); ++i) {
    const size_t bytes = layout_.ChunkBytes(chunks[i]);
    batch.bytes.emplace_back(slot.pinned.data() + at, bytes);
    at += bytes;
    if (own_order) continue;
    if (i + 1 < chunks.size() && chunks[i + 1] == chunks[i] + 1) continue;
    const size_t end = layout_.ChunkOffset(chunks[i]) + bytes, run_bytes = at - run;
    LATTICED_RETURN_IF_ERROR(
        CopyToHost(slot.pinned.data() + run, vertices.data + end - run_bytes, run_bytes, stream));
    run = at;
  }
  if (own_order) {
    LATTICED_RETURN_IF_ERROR(kernel.ToWireOrder(vertices, chunks, slot.wire.span()));
    LATTICED_RETURN_IF_ERROR(CopyToHost(slot.pinned.data(), slot.wire.data(), total, stream));
  }
  return slot.copied->Record(stream);
}

absl::Status DeviceStaging::Run(CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                                std::span<const uint32_t> chunks, UseBatch use) {
  std::array<Batch, 2> batches;
  size_t next = 0, turn = 0;
  const auto copy_next = [&](size_t slot) {
    const size_t end = BatchEnd(chunks, next);
    batches[slot].first = next;
    const auto named = chunks.subspan(next, end - next);
    next = end;
    return Copy(slots_[slot], kernel, vertices, named, batches[slot]);
  };
  if (chunks.empty()) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(copy_next(turn));
  for (bool more = true; more; turn ^= 1) {
    LATTICED_RETURN_IF_ERROR(slots_[turn].copied->Synchronize());
    more = next < chunks.size();
    if (more) {
      LATTICED_RETURN_IF_ERROR(copy_next(turn ^ 1));
    }
    LATTICED_RETURN_IF_ERROR(use(batches[turn].first, batches[turn].bytes));
  }
  return absl::OkStatus();
}

absl::Status DeviceStaging::Fetch(CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                                  std::span<const uint32_t> chunks, UseBatch use) {
  const absl::Status status = Run(kernel, vertices, chunks, use);
  // A copy may still write to memory that goes to the next user.
  if (!status.ok()) static_cast<void>(lane_->stream().Synchronize("the copy of vertices"));
  return status;
}

size_t DeviceStaging::DeviceBytes() const {
  size_t bytes = 0;
  for (const Slot& slot : slots_) bytes += slot.wire.size_bytes();
  return bytes;
}

size_t DeviceStaging::PinnedBytes() const {
  size_t bytes = 0;
  for (const Slot& slot : slots_) bytes += slot.pinned.size();
  return bytes;
}

}  // namespace latticed
