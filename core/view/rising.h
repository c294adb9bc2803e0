// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether a list of chunks rises, each of it once. Of 10^7 patches 322,000 chunks are named on the way
// to every evaluation, and on several devices nothing is launched before.
//
// Threads  safe
#ifndef LATTICED_CORE_VIEW_RISING_H_
#define LATTICED_CORE_VIEW_RISING_H_

#include <cstdint>
#include <span>

namespace latticed {

// That every number is above the one before, and below 2^31. Without a look at those of NumbersBelow.
[[nodiscard]] bool Rise(std::span<const uint32_t> numbers);

// 0, 1, … count - 1; they stay where they are, shared by all who ask.
[[nodiscard]] std::span<const uint32_t> NumbersBelow(uint32_t count);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_RISING_H_
