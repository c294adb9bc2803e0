// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/sorted_numbers.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <numeric>

#include "core/base/mutex.h"

namespace latticed {
namespace {

// The lists of NumbersBelow. tables[n] has the numbers below 2^n; it is null until it is first
// used.
std::array<std::atomic<const uint32_t*>, 33> tables;

}  // namespace

bool IsStrictlySorted(std::span<const uint32_t> numbers) {
  const bool known = std::ranges::any_of(
      tables, [&](const auto& table) { return table.load() == numbers.data(); });
  if (known && numbers.data() != nullptr) return true;
  uint32_t falls = 0;  // no early exit, so that compilers vectorise the loop
  for (size_t i = 1; i < numbers.size(); ++i) falls |= uint32_t{numbers[i] <= numbers[i - 1]};
  return falls == 0;
}

std::span<const uint32_t> NumbersBelow(uint32_t count) {
  static Mutex mutex;
  std::atomic<const uint32_t*>& table = tables[static_cast<size_t>(std::bit_width(count))];
  const MutexLock lock(&mutex);
  if (table.load() == nullptr) {
    const size_t size = size_t{1} << std::bit_width(count);
    auto* const numbers = new uint32_t[size];
    std::iota(numbers, numbers + size, 0u);
    table = numbers;
  }
  return {table.load(), count};
}

}  // namespace latticed
