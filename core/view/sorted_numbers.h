// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Checks whether lists of chunks are sorted. A scene of 10^7 patches names 322,000 chunks for every
// evaluation, and several devices launch nothing before the list is checked.
//
// Threads  safe
#ifndef LATTICED_CORE_VIEW_SORTED_NUMBERS_H_
#define LATTICED_CORE_VIEW_SORTED_NUMBERS_H_

#include <cstdint>
#include <span>

namespace latticed {

// Whether every number is above the one before. A list made by NumbersBelow is recognised and not
// read.
[[nodiscard]] bool IsStrictlySorted(std::span<const uint32_t> numbers);

// The list 0, 1, … count - 1. It is shared by all callers and never freed.
[[nodiscard]] std::span<const uint32_t> NumbersBelow(uint32_t count);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SORTED_NUMBERS_H_
