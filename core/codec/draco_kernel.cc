// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/codec/draco_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include "core/codec/draco_kernel.h"
#include "core/codec/draco_symbols-inl.h"
#include "core/codec/rans_lanes-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::draco_kernel {
namespace HWY_NAMESPACE {

size_t CollectCountsImpl(uint32_t* histograms, size_t histogram_count, size_t stride, size_t size,
                         uint32_t* symbols, uint32_t* counts) {
  const hn::CappedTag<uint32_t, kPadding> d;
  size_t found = 0;
  for (size_t s = 0; s < size; s += hn::Lanes(d)) {
    auto sum = hn::LoadU(d, histograms + s);
    hn::StoreU(hn::Zero(d), d, histograms + s);
    for (size_t h = 1; h < histogram_count; ++h) {
      sum = hn::Add(sum, hn::LoadU(d, histograms + h * stride + s));
      hn::StoreU(hn::Zero(d), d, histograms + h * stride + s);
    }
    const auto occurs = hn::Ne(sum, hn::Zero(d));
    if (hn::AllFalse(d, occurs)) continue;
    // Whole vectors are stored: compressing into memory is slow on some processors.
    hn::StoreU(hn::Compress(hn::Iota(d, static_cast<uint32_t>(s)), occurs), d, symbols + found);
    hn::StoreU(hn::Compress(sum, occurs), d, counts + found);
    found += hn::CountTrue(d, occurs);
  }
  return found;
}

const char* TargetNameImpl() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace latticed::draco_kernel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::draco_kernel {

HWY_EXPORT(SpanOfImpl);
HWY_EXPORT(PositionSymbolsImpl);
HWY_EXPORT(NormalSymbolsImpl);
HWY_EXPORT(CollectCountsImpl);
HWY_EXPORT(HasLanesImpl);
HWY_EXPORT(CodeLanesImpl);
HWY_EXPORT(TargetNameImpl);

ValueSpan SpanOf(const uint16_t* values, size_t count) {
  return HWY_DYNAMIC_DISPATCH(SpanOfImpl)(values, count);
}
void PositionSymbols(const uint16_t* values, size_t count, ValueSpan span, uint16_t* symbols) {
  HWY_DYNAMIC_DISPATCH(PositionSymbolsImpl)(values, count, span, symbols);
}
void NormalSymbols(const uint8_t* s, const uint8_t* t, size_t count, int bits, uint16_t* s_symbols,
                   uint16_t* t_symbols) {
  HWY_DYNAMIC_DISPATCH(NormalSymbolsImpl)(s, t, count, bits, s_symbols, t_symbols);
}
size_t CollectCounts(uint32_t* histograms, size_t histogram_count, size_t stride, size_t size,
                     uint32_t* symbols, uint32_t* counts) {
  return HWY_DYNAMIC_DISPATCH(CollectCountsImpl)(histograms, histogram_count, stride, size, symbols,
                                                 counts);
}
bool HasLanes() { return HWY_DYNAMIC_DISPATCH(HasLanesImpl)(); }
void CodeLanes(size_t points, LaneStreams& positions, LaneStreams* normals) {
  HWY_DYNAMIC_DISPATCH(CodeLanesImpl)(points, positions, normals);
}
const char* TargetName() { return HWY_DYNAMIC_DISPATCH(TargetNameImpl)(); }

}  // namespace latticed::draco_kernel
#endif  // HWY_ONCE
