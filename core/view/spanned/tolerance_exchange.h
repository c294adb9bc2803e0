// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates the slices of a view with a tolerance so that they choose the levels of one view of the whole plan:
//
//   bounds of all slices -> the largest of each shared edge -> levels and patterns -> number of points -> points
//                                                                ^ tolerance doubled while too many
//
// Devices work at once between the arrows, where all wait for the host. Only edges on the cuts are exchanged: 4 bytes each
// way.
//
// Errors   those of the slices, and kInvalidArgument, reason UNSUPPORTED, where a view is none
// Threads  one at a time
#ifndef LATTICED_CORE_VIEW_SPANNED_TOLERANCE_EXCHANGE_H_
#define LATTICED_CORE_VIEW_SPANNED_TOLERANCE_EXCHANGE_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/backend.h"
#include "core/view/spanned/shared_edges.h"
#include "core/view/spanned/tolerance_slice.h"

namespace latticed {

class ToleranceExchange {
 public:
  // The views of all slices, each with `spec`; they outlive the exchange.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<ToleranceExchange>> Create(
      const DeformPlan& plan, const ViewSpec& spec, std::shared_ptr<const SharedEdges> shared,
      std::span<DeformView* const> views);

  // chunks[s]: those of slice s, in its own numbers.
  [[nodiscard]] absl::Status Evaluate(std::span<const Vec3d> control_points,
                                      const QuantisationBox& box,
                                      std::span<const std::span<const uint32_t>> chunks);

  // Excludes the shared edges.
  size_t MemoryBytes() const { return BytesFor(*shared_); }
  // The most host memory that a view takes beyond the traits of its slices: also what each of these keeps to exchange
  // bounds.
  static size_t MostBytes(const SharedEdges& shared);

 private:
  ToleranceExchange(const DeformPlan& plan, const ViewSpec& spec,
                    std::shared_ptr<const SharedEdges> shared, std::vector<ToleranceSlice*> slices);
  static size_t BytesFor(const SharedEdges& shared);
  absl::Status Share();
  absl::Status GatherBounds();
  // Returns the number of points of all slices.
  absl::StatusOr<uint64_t> Choose(double curvature_tolerance);

  const ViewSpec spec_;
  const uint64_t most_points_;
  const std::shared_ptr<const SharedEdges> shared_;
  const std::vector<ToleranceSlice*> slices_;
  std::vector<float> largest_;              // by number of the edge
  std::vector<std::vector<float>> raised_;  // by slice: the same, of its edges
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_TOLERANCE_EXCHANGE_H_
