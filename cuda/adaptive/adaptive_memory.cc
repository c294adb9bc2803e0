// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/adaptive_memory.h"

#include <utility>

#include "cuda/device/block_parts.h"
#include "cuda/device/table_upload.h"

namespace latticed {
namespace {

constexpr char kLevelsPurpose[] = "levels";

// Padded to whole chunks.
size_t PaddedPatches(const DeformPlan& plan) {
  return plan.chunk_count() * limits::kPatchesPerChunk;
}

absl::StatusOr<size_t> ScanScratchBytes(const DeformPlan& plan) {
  size_t bytes = 0;
  const auto error = kernels::ScanBytes(static_cast<uint32_t>(plan.chunk_count()), bytes);
  if (error != cudaSuccess) return CudaStatus(error, "the sums of points");
  return bytes;
}

uint64_t TableBytes(const DeformPlan& plan) {
  const FlatPatterns& flat = FlatPatterns::Get();
  return TableUpload::BlockBytes({3 * plan.patches.size() * sizeof(uint32_t),
                                  flat.heads.size() * sizeof(kernels::PatternHead),
                                  flat.places.size() * sizeof(kernels::PatternPlace),
                                  flat.triangles.size() * sizeof(kernels::PatternTriangle)});
}

}  // namespace

std::vector<uint32_t> PatchEdges(const DeformPlan& plan) {
  std::vector<uint32_t> edges;
  edges.reserve(3 * plan.patches.size());
  for (const Patch& patch : plan.patches) {
    edges.insert(edges.end(), patch.edge.begin(), patch.edge.end());
  }
  return edges;
}

AdaptiveMemory::Parts AdaptiveMemory::PartsOf(const DeformPlan& plan, size_t scan_bytes) {
  BlockParts block;
  Parts parts{};
  parts.reach = block.Add(plan.boxes.size() * 3 * sizeof(uint32_t));
  parts.slack =
      block.Add(plan.boxes.size() * kernels::SlackSums(plan.is_weighted()) * sizeof(float));
  parts.edge_bounds = block.Add(plan.patches.size() * 3 * sizeof(float));
  parts.mixed_bounds = block.Add(plan.patches.size() * 3 * sizeof(float));
  parts.first_points = block.Add(plan.patches.size() * sizeof(uint16_t));
  parts.scan = block.Add(scan_bytes);
  parts.edge_maxima = block.Add(plan.edges.size() * sizeof(uint32_t));
  parts.largest_error = block.Add(sizeof(uint32_t));
  parts.chunk_first = block.Add((plan.chunk_count() + 1) * sizeof(uint64_t));
  parts.codes = block.Add(PaddedPatches(plan) * sizeof(uint16_t));
  parts.end = block.end();
  return parts;
}

absl::StatusOr<uint64_t> AdaptiveMemory::BytesFor(const DeformPlan& plan) {
  LATTICED_ASSIGN_OR_RETURN(const size_t scan, ScanScratchBytes(plan));
  return TableBytes(plan) + PartsOf(plan, scan).end;
}

absl::StatusOr<AdaptiveMemory> AdaptiveMemory::Create(const DeformPlan& plan,
                                                      DeviceReservation& from,
                                                      cudaStream_t stream) {
  AdaptiveMemory memory;
  memory.stream_ = stream;
  LATTICED_ASSIGN_OR_RETURN(const size_t scan, ScanScratchBytes(plan));
  memory.parts_ = PartsOf(plan, scan);
  LATTICED_ASSIGN_OR_RETURN(memory.block_, DeviceBuffer<uint8_t>::Create(
                                               from, kLevelsPurpose, memory.parts_.end, stream));
  const FlatPatterns& flat = FlatPatterns::Get();
  TableUpload upload;
  upload.Add(PatchEdges(plan), memory.tables_.edges);
  upload.Add(flat.heads, memory.tables_.heads);
  upload.Add(flat.places, memory.tables_.places);
  upload.Add(flat.triangles, memory.tables_.triangles);
  LATTICED_ASSIGN_OR_RETURN(memory.table_block_, upload.Send(from, kLevelsPurpose, stream));
  LATTICED_RETURN_IF_ERROR(memory.Clear(memory.parts_.reach, memory.parts_.slack));
  // The pads of results are copied too.
  LATTICED_RETURN_IF_ERROR(memory.Clear(memory.parts_.chunk_first, memory.parts_.end));
  return memory;
}

kernels::AdaptiveState AdaptiveMemory::state() const {
  uint8_t* const block = block_.data();
  return {.reach = reinterpret_cast<uint32_t*>(block + parts_.reach),
          .slack = reinterpret_cast<float*>(block + parts_.slack),
          .edge_bounds = reinterpret_cast<float*>(block + parts_.edge_bounds),
          .mixed_bounds = reinterpret_cast<float*>(block + parts_.mixed_bounds),
          .edge_maxima = reinterpret_cast<uint32_t*>(block + parts_.edge_maxima),
          .largest_error = reinterpret_cast<uint32_t*>(block + parts_.largest_error),
          .chunk_first = reinterpret_cast<uint64_t*>(block + parts_.chunk_first),
          .codes = reinterpret_cast<uint16_t*>(block + parts_.codes),
          .first_points = reinterpret_cast<uint16_t*>(block + parts_.first_points)};
}

DeviceSpan<uint8_t> AdaptiveMemory::scan_scratch() const {
  return {block_.data() + parts_.scan, parts_.edge_maxima - parts_.scan};
}

DeviceSpan<const uint8_t> AdaptiveMemory::results() const {
  return {block_.data() + parts_.largest_error, parts_.end - parts_.largest_error};
}

absl::Status AdaptiveMemory::ClearMaxima() const {
  return Clear(parts_.edge_maxima, parts_.chunk_first);
}

absl::Status AdaptiveMemory::ClearError() const {
  return Clear(parts_.largest_error, parts_.chunk_first);
}

absl::Status AdaptiveMemory::Clear(size_t begin, size_t end) const {
  return CudaStatus(cudaMemsetAsync(block_.data() + begin, 0, end - begin, stream_), "the levels");
}

AdaptiveResults::AdaptiveResults(const DeformPlan& plan, const uint8_t* bytes) : bytes_(bytes) {
  const auto parts = AdaptiveMemory::PartsOf(plan, 0);
  const auto at = [&](size_t part) { return bytes + (part - parts.largest_error); };
  chunk_first_ = {reinterpret_cast<const uint64_t*>(at(parts.chunk_first)), plan.chunk_count() + 1};
  codes_ = {reinterpret_cast<const uint16_t*>(at(parts.codes)), PaddedPatches(plan)};
}

float AdaptiveResults::largest_error() const {
  float error = 0;
  std::memcpy(&error, bytes_, sizeof(error));
  return error;
}

}  // namespace latticed
