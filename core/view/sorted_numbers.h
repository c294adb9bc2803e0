// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Checks lists of chunks. A scene of 10^7 patches names 322,000 chunks for every evaluation, and on several devices
// nothing is launched before they are checked.
//
// Threads  safe
#ifndef LATTICED_CORE_VIEW_SORTED_NUMBERS_H_
#define LATTICED_CORE_VIEW_SORTED_NUMBERS_H_

#include <cstdint>
#include <span>

namespace latticed {

// Whether every number is above the one before. Lists made by NumbersBelow are known, and not read.
[[nodiscard]] bool IsStrictlySorted(std::span<const uint32_t> numbers);

// 0, 1, … count - 1. The list is never freed, and shared by all who ask.
[[nodiscard]] std::span<const uint32_t> NumbersBelow(uint32_t count);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SORTED_NUMBERS_H_
