// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of a slice of a plan (core/ffd/plan/plan_slice.h) that bounds second derivatives. The slack of its bounds depends on how
// far all patches of a box reach, also those of other slices. With the reach of all, its bounds have the bits of those of
// the whole plan.
//
// Units    box-local coordinates
// Errors   those of DeformView::Evaluate
// Threads  one at a time
#ifndef LATTICED_CORE_VIEW_SPANNED_REACH_SLICE_H_
#define LATTICED_CORE_VIEW_SPANNED_REACH_SLICE_H_

#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"

namespace latticed {

class ReachSlice {
 public:
  virtual ~ReachSlice() = default;

  // By box, as PatchReach of core/adaptive/curvature_slack.h: the largest of the slice's patches. Waits.
  [[nodiscard]] virtual absl::StatusOr<std::vector<Vec3d>> BoxReach() = 0;
  // reach: the largest of all slices.
  [[nodiscard]] virtual absl::Status SetReach(std::span<const Vec3d> reach) = 0;
};

// Gives each slice the largest reach of all. Call it once, before the first evaluation.
[[nodiscard]] absl::Status ShareReach(std::span<ReachSlice* const> slices);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_REACH_SLICE_H_
