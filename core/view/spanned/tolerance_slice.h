// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view with a tolerance of a slice of a plan (core/ffd/plan/plan_slice.h). Its levels depend on patches of other slices, in two
// ways: an edge takes the largest bound in all of its patches, and the slack of bounds the reach of all patches of a box.
// tolerance_exchange.h gives each slice the maxima of all, and the views then have the bits of one view of the whole plan.
//
//   ShareEdges            once, before the first evaluation, as is ShareReach of reach_slice.h
//   Bound                 an evaluation begins, in place of DeformView::Evaluate
//   SharedBounds          … what other slices need
//   Choose, CountPoints   … levels and patterns; again with another tolerance, as often as needed
//   Finish                … after which the view is as after Evaluate
//
// An evaluation ends also where one of its steps fails. The next one then names all chunks.
//
// Units    world
// Errors   those of DeformView::Evaluate
// Threads  one at a time. Steps that "wait" do so for the device; others enqueue, so that devices work at once
#ifndef LATTICED_CORE_VIEW_SPANNED_TOLERANCE_SLICE_H_
#define LATTICED_CORE_VIEW_SPANNED_TOLERANCE_SLICE_H_

#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/plan/quantisation_box.h"
#include "core/view/spanned/reach_slice.h"

namespace latticed {

class ToleranceSlice : public ReachSlice {
 public:
  // edges: those of the slice's plan that other slices have too, ascending.
  [[nodiscard]] virtual absl::Status ShareEdges(std::span<const uint32_t> edges) = 0;

  // Valid arguments of DeformView::Evaluate; `chunks` may be empty. The spans stay valid until Finish.
  [[nodiscard]] virtual absl::Status Bound(std::span<const Vec3d> control_points,
                                           const QuantisationBox& box,
                                           std::span<const uint32_t> chunks) = 0;
  // For each shared edge, the largest bound in the slice's patches. Waits. Valid until the next step.
  [[nodiscard]] virtual absl::StatusOr<std::span<const float>> SharedBounds() = 0;
  // shared_bounds: the largest of all slices. curvature_tolerance: see CurvatureTolerance.
  [[nodiscard]] virtual absl::Status Choose(double curvature_tolerance,
                                            std::span<const float> shared_bounds) = 0;
  // The points of all patches with the patterns that were chosen. Waits.
  [[nodiscard]] virtual absl::StatusOr<uint64_t> CountPoints() = 0;
  [[nodiscard]] virtual absl::Status Finish() = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_TOLERANCE_SLICE_H_
