// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Rows to lane order, [point][component][lane], by streaming stores. Included once per instruction
// set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_LANE_ORDER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_LANE_ORDER_INL_H_
#undef LATTICED_CORE_CPU_FUSED_LANE_ORDER_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_LANE_ORDER_INL_H_
#endif

#include <algorithm>

#include "core/cpu/fused_kernel.h"
#include "hwy/cache_control.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

// The next `count` points, or as many as are left.
HWY_INLINE void SendLaneOrder(LaneOrderStores& stores, size_t count) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<float, kLanes> d;
  const size_t end = std::min(stores.done + count, stores.scratch.points);
  float* to = stores.destination + stores.done * stores.components * kLanes;
  for (; stores.done < end; ++stores.done) {
    for (size_t c = 0; c < stores.components; ++c) {
      const float* row = stores.scratch.Row(c, stores.done);
      for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(d), to += hn::Lanes(d)) {
        hn::Stream(hn::Load(d, row + lane), d, to);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_LANE_ORDER_INL_H_
