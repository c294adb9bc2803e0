// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan that is prepared for one pipeline on one device. Twin of core/cpu/cpu_target.h. Views may
// outlive the target: each keeps the plan, the device's tables and the context alive.
#ifndef LATTICED_CUDA_CUDA_TARGET_H_
#define LATTICED_CUDA_CUDA_TARGET_H_

#include <memory>

#include "core/backend.h"
#include "cuda/device/cuda_context.h"

namespace latticed {

// kResourceExhausted where the tables do not fit.
[[nodiscard]] absl::StatusOr<std::shared_ptr<DeformTarget>> MakeCudaTarget(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
    std::shared_ptr<CudaContext> context);

}  // namespace latticed

#endif  // LATTICED_CUDA_CUDA_TARGET_H_
