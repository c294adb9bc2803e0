// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bézier control nets of patches, brought to the host.                Cui & Feng 2014, formula (6)
//
//   T = inv(B) Rs, in double
//
// Errors   those of cuda_gemm.h, device_buffer.h and pinned_memory.h
// Threads  safe; borrows a lane of its own and waits for it
#ifndef LATTICED_CUDA_GEMM_CUDA_CONTROL_NETS_H_
#define LATTICED_CUDA_GEMM_CUDA_CONTROL_NETS_H_

#include <memory>
#include <span>
#include <vector>

#include "cuda/device/cuda_context.h"
#include "cuda/plan/device_plan.h"

namespace latticed {

// As DeformTarget::ControlNets, with arguments that are checked already.
[[nodiscard]] absl::StatusOr<std::vector<double>> CudaControlNets(
    const std::shared_ptr<const DeformPlan>& plan, const DevicePlan& device_plan,
    CudaContext& context, std::span<const Vec3d> control_points, size_t first, size_t last);

}  // namespace latticed

#endif  // LATTICED_CUDA_GEMM_CUDA_CONTROL_NETS_H_
