// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Seeds of random tests. The environment's LATTICED_SEED replaces the usual one.
#ifndef LATTICED_TESTS_SUPPORT_SEED_H_
#define LATTICED_TESTS_SUPPORT_SEED_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace latticed::testing {

inline uint32_t SeedOr(uint32_t usual) {
  const char* const given = std::getenv("LATTICED_SEED");
  return given == nullptr ? usual : static_cast<uint32_t>(std::strtoul(given, nullptr, 10));
}

// The seed of one case of a parameterised test: the next case has the next seed. Prints it.
inline uint32_t SeedOfCase(uint32_t usual, int number) {
  const uint32_t seed = SeedOr(usual) + static_cast<uint32_t>(number);
  ::testing::Test::RecordProperty("seed", static_cast<int>(seed));
  std::printf("seed %u\n", seed);
  return seed;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_SEED_H_
