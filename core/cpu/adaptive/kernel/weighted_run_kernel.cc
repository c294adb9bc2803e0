// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The runs of meshes with vertex weights. Compiled once per instruction set, as adaptive_kernel.cc, and apart from it, so that
// its code does not change.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cpu/adaptive/kernel/weighted_run_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires this include to follow foreach_target.
#include "core/cpu/adaptive/kernel/adaptive_kernel.h"
#include "core/cpu/adaptive/kernel/adaptive_run-inl.h"
#include "core/cpu/fused/kernel/fused_degrees-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

template <int D0, int D1, int D2>
struct WeightedRunInstance {
  static void Run(RunArguments& arguments) { RunInstance<D0, D1, D2, true>::Run(arguments); }
};

void EvaluateWeightedRunImpl(RunArguments& arguments) {
  WithDegrees<WeightedRunInstance>(arguments.degree,
                                   [&](auto instance) { instance.Run(arguments); });
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::fused {

HWY_EXPORT(EvaluateWeightedRunImpl);

void EvaluateWeightedRun(RunArguments& arguments) {
  HWY_DYNAMIC_DISPATCH(EvaluateWeightedRunImpl)(arguments);
}

}  // namespace latticed::fused
#endif  // HWY_ONCE
