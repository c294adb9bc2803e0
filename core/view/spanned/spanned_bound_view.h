// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of edge bounds whose patches are shared out among views, each of a slice of the plan (core/ffd/plan/plan_slice.h) and
// each, as a rule, on a device of its own. Clients see the whole plan, and the bytes of one device.
//
//   bytes of each slice's edges -> the largest byte of each edge on a cut -> bytes of the plan's edges, by its chunks
//
// A slice is a plan: its edges have numbers of their own, in the order of first use in the slice. An edge on a cut is an
// edge of several slices. Its byte is the largest of theirs, since bytes grow with bounds (core/patches/edge_bound.h), and
// it belongs to the chunk that uses it first in the plan. All other edges of a chunk are the same in plan and slice, in the
// same order.
//
// Memory   a byte an edge on the host, beside the slices' own
// Errors   those of core/view/checked_view.h and of the slices
// Threads  one thread at a time; Evaluate uses one thread per slice
#ifndef LATTICED_CORE_VIEW_SPANNED_SPANNED_BOUND_VIEW_H_
#define LATTICED_CORE_VIEW_SPANNED_SPANNED_BOUND_VIEW_H_

#include <memory>
#include <vector>

#include "core/view/checked_view.h"
#include "core/view/spanned/shared_edges.h"

namespace latticed {

class SpannedBoundView : public CheckedView {
 public:
  struct Slice {
    uint32_t first_chunk;               // of the plan; the first slice's is 0, and they rise
    std::vector<uint32_t> first_edges;  // FirstEdges of the slice's plan
    std::unique_ptr<DeformView> view;
  };
  // kInvalidArgument, reason UNSUPPORTED, where a view cannot share its bounds.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<SpannedBoundView>> Create(
      std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
      std::shared_ptr<const SharedEdges> shared, std::vector<Slice> slices);

  std::span<const uint32_t> also_changed() const override { return also_changed_; }
  MemoryUse memory() const override;

  // The most host memory that a view takes beyond its slices' traits.
  static uint64_t MostBytes(const DeformPlan& plan, const SharedEdges& shared);

 private:
  SpannedBoundView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                   std::shared_ptr<const SharedEdges> shared, std::vector<Slice> slices);

  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override;
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  size_t SizeOf(uint32_t chunk) const override { return Bytes(chunk).size(); }
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;

  // Of the edges that a chunk uses first.
  std::span<const uint8_t> Bytes(uint32_t chunk) const;
  // By slice: those of `chunks` that it has, in its own numbers.
  std::vector<std::vector<uint32_t>> ShareOut(std::span<const uint32_t> chunks) const;
  // Takes the bytes of a chunk of a slice. Those of edges on cuts wait for RaiseShared.
  absl::Status TakeChunk(size_t slice, uint32_t chunk);
  void RaiseShared();
  void SetByte(uint32_t edge, uint8_t byte, uint32_t chunk);
  uint32_t End(size_t slice) const;  // its last chunk of the plan, plus one

  const std::shared_ptr<const SharedEdges> shared_;
  const std::vector<Slice> slices_;
  const std::vector<uint32_t> first_edges_;         // FirstEdges of the plan
  std::vector<uint8_t> bytes_;                      // by edge of the plan
  std::vector<std::vector<uint8_t>> shared_bytes_;  // by slice: its own bytes of its shared edges
  std::vector<uint8_t> largest_, scratch_;
  std::vector<uint8_t> is_changed_;  // by chunk of the plan; all 0 between two evaluations
  std::vector<uint32_t> also_changed_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_SPANNED_BOUND_VIEW_H_
