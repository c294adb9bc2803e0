// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/decoder/lanes/lane_kernel.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include "client/decoder/lanes/lane_kernel.h"
#include "client/decoder/lanes/rans_lanes-inl.h"
#include "client/decoder/lanes/scalar_points-inl.h"
#include "hwy/highway.h"
#if HWY_TARGET != HWY_SCALAR  // eight lanes need vectors
#include "client/decoder/lanes/points-inl.h"
#endif

HWY_BEFORE_NAMESPACE();
namespace latticed::decoder::lane_kernel {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR
void WritePointsImpl(PointLanes& lanes) {
  for (size_t k = 0; k < kLanes; ++k) WriteLane(lanes, k);
}
#endif
const char* TargetNameImpl() { return hwy::TargetName(HWY_TARGET); }
}  // namespace HWY_NAMESPACE
}  // namespace latticed::decoder::lane_kernel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::decoder::lane_kernel {

HWY_EXPORT(DecodeSymbolsImpl);
HWY_EXPORT(WritePointsImpl);
HWY_EXPORT(TargetNameImpl);

void DecodeSymbols(SymbolLane* lanes, size_t count) {
  HWY_DYNAMIC_DISPATCH(DecodeSymbolsImpl)(lanes, count);
}
void WritePoints(PointLanes& lanes) { HWY_DYNAMIC_DISPATCH(WritePointsImpl)(lanes); }
const char* TargetName() { return HWY_DYNAMIC_DISPATCH(TargetNameImpl)(); }

}  // namespace latticed::decoder::lane_kernel
#endif  // HWY_ONCE
