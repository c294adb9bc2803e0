// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel of a target, as one view uses it.
#ifndef LATTICED_CORE_CPU_FUSED_FUSED_VIEW_KERNEL_H_
#define LATTICED_CORE_CPU_FUSED_FUSED_VIEW_KERNEL_H_

#include <memory>
#include <utility>

#include "core/cpu/cpu_context.h"
#include "core/cpu/fused/cpu_fused.h"
#include "core/cpu/vertex_kernel.h"

namespace latticed {

class FusedViewKernel : public VertexKernel {
 public:
  FusedViewKernel(std::shared_ptr<const FusedKernel> kernel, const ViewSpec& spec,
                  std::shared_ptr<CpuContext> context)
      : kernel_(std::move(kernel)), spec_(spec), context_(std::move(context)) {}

  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks, std::span<uint8_t> vertices) override {
    return kernel_->Evaluate(control_points, box, chunks, spec_, vertices, context_->arena);
  }
  MemoryUse memory() const override { return {}; }

 private:
  const std::shared_ptr<const FusedKernel> kernel_;
  const ViewSpec spec_;
  const std::shared_ptr<CpuContext> context_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_FUSED_FUSED_VIEW_KERNEL_H_
