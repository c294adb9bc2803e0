// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/bounds/edge_bound_memory.h"

#include <utility>

#include "cuda/adaptive/adaptive_memory.h"
#include "cuda/device/block_parts.h"
#include "cuda/device/table_upload.h"

namespace latticed {
namespace {

constexpr char kBoundsPurpose[] = "bounds";

}  // namespace

EdgeBoundMemory::Parts EdgeBoundMemory::PartsOf(const DeformPlan& plan) {
  BlockParts block;
  Parts parts{};
  parts.reach = block.Add(plan.boxes.size() * 3 * sizeof(uint32_t));
  parts.slack =
      block.Add(plan.boxes.size() * kernels::SlackSums(plan.is_weighted()) * sizeof(float));
  parts.bounds = block.Add(plan.patches.size() * 3 * sizeof(float));
  parts.maxima = block.Add(plan.edges.size() * sizeof(uint32_t));
  parts.bytes = block.Add(plan.edges.size());
  parts.end = block.end();
  return parts;
}

uint64_t EdgeBoundMemory::BytesFor(const DeformPlan& plan) {
  return PartsOf(plan).end + TableUpload::BlockBytes({3 * plan.patches.size() * sizeof(uint32_t),
                                                      (plan.chunk_count() + 1) * sizeof(uint32_t)});
}

absl::StatusOr<EdgeBoundMemory> EdgeBoundMemory::Create(const DeformPlan& plan,
                                                        std::vector<uint32_t> first_edges,
                                                        DeviceReservation& from,
                                                        cudaStream_t stream) {
  EdgeBoundMemory memory;
  memory.stream_ = stream;
  memory.parts_ = PartsOf(plan);
  LATTICED_ASSIGN_OR_RETURN(memory.block_, DeviceBuffer<uint8_t>::Create(
                                               from, kBoundsPurpose, memory.parts_.end, stream));
  TableUpload upload;
  upload.Add(PatchEdges(plan), memory.edges_);
  upload.Add(std::move(first_edges), memory.first_edges_);
  LATTICED_ASSIGN_OR_RETURN(memory.table_block_, upload.Send(from, kBoundsPurpose, stream));
  LATTICED_RETURN_IF_ERROR(memory.Clear(0, memory.parts_.end));
  return memory;
}

kernels::AdaptiveTables EdgeBoundMemory::tables() const {
  return {.edges = edges_, .heads = nullptr, .places = nullptr, .triangles = nullptr};
}

kernels::AdaptiveState EdgeBoundMemory::state() const {
  uint8_t* const block = block_.data();
  kernels::AdaptiveState state{};
  state.reach = reinterpret_cast<uint32_t*>(block + parts_.reach);
  state.slack = reinterpret_cast<float*>(block + parts_.slack);
  state.edge_bounds = reinterpret_cast<float*>(block + parts_.bounds);
  state.edge_maxima = reinterpret_cast<uint32_t*>(block + parts_.maxima);
  return state;
}

absl::Status EdgeBoundMemory::ClearMaxima() const { return Clear(parts_.maxima, parts_.bytes); }

absl::Status EdgeBoundMemory::Clear(size_t begin, size_t end) const {
  return CudaStatus(cudaMemsetAsync(block_.data() + begin, 0, end - begin, stream_), "the bounds");
}

}  // namespace latticed
