// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What all views of a target on the CPU share of a plan.
//
// Threads  immutable
#ifndef LATTICED_CORE_CPU_FUSED_FUSED_PLAN_H_
#define LATTICED_CORE_CPU_FUSED_FUSED_PLAN_H_

#include <memory>
#include <utility>

#include "core/cpu/fused/box_polynomials.h"
#include "core/cpu/fused/fused_layout.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed::fused {

struct FusedPlan {
  explicit FusedPlan(std::shared_ptr<const DeformPlan> deform_plan)
      : plan(std::move(deform_plan)), polynomials(plan), layout(plan, polynomials) {}

  const std::shared_ptr<const DeformPlan> plan;
  const BoxPolynomials polynomials;
  const FusedLayout layout;
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_FUSED_PLAN_H_
