// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/row_sum.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>

namespace latticed {

int64_t RowSum(std::string_view bytes, int64_t key, uint64_t second_key) {
  const std::array<uint64_t, 2> keys = {static_cast<uint64_t>(key), second_key};
  const XXH64_hash_t seed = XXH3_64bits(keys.data(), sizeof(keys));
  return static_cast<int64_t>(XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed));
}

int64_t IdRowSum(std::string_view id, std::string_view bytes) {
  return RowSum(bytes, RowSum(id, 0));
}

}  // namespace latticed
