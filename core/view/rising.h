// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether a list of chunks rises, each of it once. Of 10^7 patches 322,000 chunks are named on the way
// to every evaluation, and on several devices nothing is launched before.
//
// Threads  pure functions
#ifndef LATTICED_CORE_VIEW_RISING_H_
#define LATTICED_CORE_VIEW_RISING_H_

#include <cstdint>
#include <span>

namespace latticed {

// That every number is above the one before, and below 2^31.
[[nodiscard]] bool Rise(std::span<const uint32_t> numbers);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_RISING_H_
