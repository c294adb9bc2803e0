// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Values between here and PostgreSQL, in its binary formats: numbers are big-endian, bytes are themselves, and an array
// is
//
//   dimensions = 1 | has nulls = 0 | type of elements | length | first index = 1 | (size, bytes) of each element
//
// of 32 bits each, except the bytes.
#ifndef LATTICED_SERVER_STORE_POSTGRES_PARAMETERS_H_
#define LATTICED_SERVER_STORE_POSTGRES_PARAMETERS_H_

#include <libpq-fe.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace latticed {

// The parameters $1, $2, … of a statement, in the order of the calls.
class PgParameters {
 public:
  PgParameters& Number(int64_t value);  // bigint
  PgParameters& Number(uint64_t value) { return Number(static_cast<int64_t>(value)); }
  // bytea. `value` outlives the statement.
  PgParameters& Bytes(std::string_view value);
  PgParameters& Text(std::string_view value);                           // the same of text
  PgParameters& Numbers(std::span<const int64_t> values);               // bigint[]
  PgParameters& ByteStrings(std::span<const std::string_view> values);  // bytea[]

 private:
  friend class PgConnection;

  PgParameters& Own(Oid type, std::string bytes);
  PgParameters& Add(Oid type, std::string_view bytes);

  std::vector<Oid> types_;
  std::vector<std::string_view> values_;
  std::vector<std::vector<char>> owned_;  // a vector's bytes stay where they are when it moves
};

// The number in a field of a row.
[[nodiscard]] int64_t PgNumber(std::string_view field);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_PARAMETERS_H_
