// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan prepared for one pipeline on the CPU. Immutable; its views keep it alive through the plan
// and the shared tables.
#ifndef LATTICED_CORE_CPU_CPU_TARGET_H_
#define LATTICED_CORE_CPU_CPU_TARGET_H_

#include <memory>
#include <vector>

#include "core/backend.h"
#include "core/cpu/cpu_context.h"
#include "core/cpu/fused/cpu_fused.h"
#include "core/ffd/shared_points.h"

namespace latticed {

class CpuTarget : public DeformTarget {
 public:
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<DeformTarget>> Create(
      std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
      std::shared_ptr<CpuContext> context);

  const DeformPlan& plan() const override { return *plan_; }
  Pipeline pipeline() const override { return pipeline_; }
  ViewTraits Traits(const ViewSpec& spec) const override;
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override;
  // kInvalidArgument for a range of patches or a count of control points that does not fit.
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override;
  MemoryUse memory() const override;

 private:
  CpuTarget(std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
            std::shared_ptr<CpuContext> context);

  std::shared_ptr<const DeformPlan> plan_;
  Pipeline pipeline_;
  std::shared_ptr<CpuContext> context_;
  std::shared_ptr<const SharedPoints> shared_;  // GEMM pipelines only
  std::shared_ptr<const FusedKernel> fused_;    // pipeline fused only
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_TARGET_H_
