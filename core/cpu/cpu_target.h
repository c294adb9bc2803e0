// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan prepared for one pipeline on the CPU. Its views keep it alive through the plan and the shared
// tables.
#ifndef LATTICED_CORE_CPU_CPU_TARGET_H_
#define LATTICED_CORE_CPU_CPU_TARGET_H_

#include <memory>

#include "core/backend.h"
#include "core/cpu/cpu_context.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<std::shared_ptr<DeformTarget>> MakeCpuTarget(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline, std::shared_ptr<CpuContext> context);

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_TARGET_H_
