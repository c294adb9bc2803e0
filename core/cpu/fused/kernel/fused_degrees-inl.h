// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From degrees to the code that is compiled for them.
// Included once per instruction set by each kernel.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DEGREES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DEGREES_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DEGREES_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DEGREES_INL_H_
#endif

#include <array>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

// Calls f with the Instance for these degrees, which must be in falling order.
template <template <int, int, int> class Instance, class F>
void WithDegrees(const std::array<int, 3>& degree, const F& f) {
  switch (degree[0] * 100 + degree[1] * 10 + degree[2]) {
    case 111:
      return f(Instance<1, 1, 1>());
    case 211:
      return f(Instance<2, 1, 1>());
    case 221:
      return f(Instance<2, 2, 1>());
    case 222:
      return f(Instance<2, 2, 2>());
    case 311:
      return f(Instance<3, 1, 1>());
    case 321:
      return f(Instance<3, 2, 1>());
    case 322:
      return f(Instance<3, 2, 2>());
    case 331:
      return f(Instance<3, 3, 1>());
    case 332:
      return f(Instance<3, 3, 2>());
    case 333:
      return f(Instance<3, 3, 3>());
    default:
      return;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DEGREES_INL_H_
