// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/view/rising.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <mutex>
#include <numeric>

#include "core/view/rising.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Among numbers below 2^31 a step that does not rise, less one, is negative: one bit of either tells.
bool RiseImpl(const uint32_t* numbers, size_t count) {
  if (count == 0) return true;
  const hn::ScalableTag<uint32_t> d;
  const size_t lanes = hn::Lanes(d);
  auto seen = hn::Zero(d);
  size_t i = 1;
  for (; i + lanes <= count; i += lanes) {
    const auto at = hn::LoadU(d, numbers + i);
    const auto step = hn::Sub(at, hn::LoadU(d, numbers + i - 1));
    seen = hn::Or(seen, hn::Or(at, hn::Sub(step, hn::Set(d, 1))));
  }
  uint32_t rest = numbers[0];
  for (; i < count; ++i) rest |= numbers[i] | (numbers[i] - numbers[i - 1] - 1);
  return rest >> 31 == 0 && hn::AllTrue(d, hn::Eq(hn::ShiftRight<31>(seen), hn::Zero(d)));
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed {

HWY_EXPORT(RiseImpl);

namespace {

// Of NumbersBelow: the first 2^n are at n, or null; made when they are wanted and never freed.
std::array<std::atomic<const uint32_t*>, 32> tables;

}  // namespace

bool Rise(std::span<const uint32_t> numbers) {
  const bool known = std::ranges::any_of(
      tables, [&](const auto& table) { return table.load() == numbers.data(); });
  if (known && numbers.data() != nullptr) return true;
  return HWY_DYNAMIC_DISPATCH(RiseImpl)(numbers.data(), numbers.size());
}

std::span<const uint32_t> NumbersBelow(uint32_t count) {
  static std::mutex mutex;
  std::atomic<const uint32_t*>& table = tables[static_cast<size_t>(std::bit_width(count))];
  const std::scoped_lock lock(mutex);
  if (table.load() == nullptr) {
    const size_t size = size_t{1} << std::bit_width(count);
    auto* const numbers = new uint32_t[size];
    std::iota(numbers, numbers + size, 0u);
    table = numbers;
  }
  return {table.load(), count};
}

}  // namespace latticed
#endif  // HWY_ONCE
