// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A target whose chunks are shared out among other targets, each of a slice of the plan
// (core/ffd/plan/plan_slice.h). Its vertices are bit for bit those of one target of the whole plan.
//
// The whole plan stays on the host beside the slices, which take about as much memory again.
//
// Errors   those of the parts; where one is refused, no part keeps anything
// Threads  as DeformTarget
#ifndef LATTICED_CORE_VIEW_SPANNED_SPANNED_TARGET_H_
#define LATTICED_CORE_VIEW_SPANNED_SPANNED_TARGET_H_

#include <memory>
#include <vector>

#include "core/backend.h"
#include "core/view/spanned/shared_edges.h"

namespace latticed {

class SpannedTarget : public DeformTarget {
 public:
  struct Part {
    uint32_t first_chunk;  // of the plan; the first part's is 0, and they rise
    std::shared_ptr<DeformTarget> target;
  };
  // At least one part, all of one pipeline; together they are the plan.
  SpannedTarget(std::shared_ptr<const DeformPlan> plan, std::vector<Part> parts);

  const DeformPlan& plan() const override { return *plan_; }
  Pipeline pipeline() const override { return parts_.front().target->pipeline(); }
  bool has_edge_bounds() const override { return parts_.front().target->has_edge_bounds(); }
  ViewTraits Traits(const ViewSpec& spec) const override;
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override;
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override;
  MemoryUse memory() const override;
  DeviceUse device_use() const override;

 private:
  absl::StatusOr<std::unique_ptr<DeformView>> CreateBoundView(const ViewSpec& spec) const;

  const std::shared_ptr<const DeformPlan> plan_;
  const std::vector<Part> parts_;
  const std::shared_ptr<const SharedEdges> shared_edges_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_SPANNED_TARGET_H_
