// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compiled once per instruction set, as core/cpu/fused/kernel/fused_kernel.cc. Only MulAdd makes fused multiply-adds, so
// that the two sides of an edge are rounded alike.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cpu/adaptive/kernel/adaptive_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires this include to follow foreach_target.
#include <cstring>

#include "core/cpu/adaptive/kernel/adaptive_bounds-inl.h"
#include "core/cpu/adaptive/kernel/adaptive_kernel.h"
#include "core/cpu/adaptive/kernel/adaptive_run-inl.h"
#include "core/cpu/fused/kernel/fused_degrees-inl.h"
#include "core/cpu/fused/kernel/fused_quantise-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

template <int D0, int D1, int D2>
struct AdaptiveInstance {
  static void Bounds(const BoundArguments& arguments) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      BoundKernel<D0, D1, D2>::Run(arguments, lane);
    }
  }

  static void Run(RunArguments& arguments) { RunInstance<D0, D1, D2, false>::Run(arguments); }
};

void BoundGroupImpl(const BoundArguments& arguments) {
  WithDegrees<AdaptiveInstance>(arguments.degree,
                                [&](auto instance) { instance.Bounds(arguments); });
}
void EvaluateRunImpl(RunArguments& arguments) {
  WithDegrees<AdaptiveInstance>(arguments.degree, [&](auto instance) { instance.Run(arguments); });
}

// Stores the lower kBytes bytes of each lane for the first `count` lanes of a vector that begins at `to`.
template <size_t kBytes>
HWY_INLINE void StoreNarrow(VI value, size_t count, uint8_t* to) {
  using T = hwy::UnsignedFromSize<kBytes>;
  const hn::Rebind<T, DI> d;
  HWY_ALIGN T narrow[kLanes];
  hn::Store(hn::DemoteTo(d, value), d, narrow);
  const size_t lanes = hn::Lanes(DI());
  if (count >= lanes) {
    std::memcpy(to, narrow, lanes * kBytes);  // of a constant size, without a call
  } else {
    std::memcpy(to, narrow, count * kBytes);
  }
}

void QuantisePositionsImpl(const float* row, size_t count, float scale, float offset, int bits,
                           uint8_t* to) {
  const DF df;
  const VI top = hn::Set(DI(), (1 << bits) - 1);
  const VF scales = hn::Set(df, scale), offsets = hn::Set(df, offset);
  for (size_t i = 0; i < count; i += hn::Lanes(df)) {
    StoreNarrow<2>(QuantisePosition(hn::Load(df, row + i), scales, offsets, top), count - i,
                   to + 2 * i);
  }
}

template <size_t kBytes>
void QuantiseNormalsOf(const std::array<const float*, 3>& rows, size_t count, int bits, uint8_t* s,
                       uint8_t* t) {
  const DF df;
  for (size_t i = 0; i < count; i += hn::Lanes(df)) {
    VI vs, vt;
    QuantiseNormalLanes(hn::Load(df, rows[0] + i), hn::Load(df, rows[1] + i),
                        hn::Load(df, rows[2] + i), bits, vs, vt);
    StoreNarrow<kBytes>(vs, count - i, s + kBytes * i);
    StoreNarrow<kBytes>(vt, count - i, t + kBytes * i);
  }
}

void QuantiseNormalsImpl(const std::array<const float*, 3>& rows, size_t count, int bits,
                         uint8_t* s, uint8_t* t) {
  if (bits <= 8) {
    QuantiseNormalsOf<1>(rows, count, bits, s, t);
  } else {
    QuantiseNormalsOf<2>(rows, count, bits, s, t);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::fused {

HWY_EXPORT(BoundGroupImpl);
HWY_EXPORT(EvaluateRunImpl);
HWY_EXPORT(QuantisePositionsImpl);
HWY_EXPORT(QuantiseNormalsImpl);

void BoundGroup(const BoundArguments& arguments) {
  HWY_DYNAMIC_DISPATCH(BoundGroupImpl)(arguments);
}
void EvaluateRun(RunArguments& arguments) { HWY_DYNAMIC_DISPATCH(EvaluateRunImpl)(arguments); }
void QuantisePositions(std::span<const float> row, float scale, float offset, int bits,
                       uint8_t* to) {
  HWY_DYNAMIC_DISPATCH(QuantisePositionsImpl)(row.data(), row.size(), scale, offset, bits, to);
}
void QuantiseNormals(const std::array<const float*, 3>& rows, size_t count, int bits, uint8_t* s,
                     uint8_t* t) {
  HWY_DYNAMIC_DISPATCH(QuantiseNormalsImpl)(rows, count, bits, s, t);
}

}  // namespace latticed::fused
#endif  // HWY_ONCE
