// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Checksums that databases of stores keep beside what they keep: a flipped bit is noticed, and a row in another one's
// place.
#ifndef LATTICED_SERVER_STORE_ROW_SUM_H_
#define LATTICED_SERVER_STORE_ROW_SUM_H_

#include <cstdint>
#include <string_view>

namespace latticed {

// Of the bytes of a row with these keys: XXH3, 64 bits.
[[nodiscard]] int64_t RowSum(std::string_view bytes, int64_t key, uint64_t second_key = 0);
// The same of a row whose key is an id.
[[nodiscard]] int64_t IdRowSum(std::string_view id, std::string_view bytes);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_ROW_SUM_H_
