// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/parameters.h"

#include <endian.h>

#include <cstring>

namespace latticed {
namespace {

// From pg_type.dat, where they never change.
constexpr Oid kByteaType = 17;
constexpr Oid kBigintType = 20;
constexpr Oid kTextType = 25;
constexpr Oid kByteaArrayType = 1001;
constexpr Oid kBigintArrayType = 1016;

void AppendInt32(std::string& bytes, uint32_t value) {
  const uint32_t wire = htobe32(value);
  bytes.append(reinterpret_cast<const char*>(&wire), sizeof(wire));
}

void AppendInt64(std::string& bytes, int64_t value) {
  const uint64_t wire = htobe64(static_cast<uint64_t>(value));
  bytes.append(reinterpret_cast<const char*>(&wire), sizeof(wire));
}

std::string ArrayHeader(Oid type, size_t length) {
  std::string bytes;
  for (const uint32_t word : {1U, 0U, type, static_cast<uint32_t>(length), 1U}) {
    AppendInt32(bytes, word);
  }
  return bytes;
}

}  // namespace

PgParameters& PgParameters::Add(Oid type, std::string_view bytes) {
  types_.push_back(type);
  values_.push_back(bytes);
  return *this;
}

PgParameters& PgParameters::Own(Oid type, std::string bytes) {
  const std::vector<char>& kept = owned_.emplace_back(bytes.begin(), bytes.end());
  return Add(type, {kept.data(), kept.size()});
}

PgParameters& PgParameters::Number(int64_t value) {
  std::string bytes;
  AppendInt64(bytes, value);
  return Own(kBigintType, std::move(bytes));
}

PgParameters& PgParameters::Bytes(std::string_view value) { return Add(kByteaType, value); }

PgParameters& PgParameters::Text(std::string_view value) { return Add(kTextType, value); }

PgParameters& PgParameters::Numbers(std::span<const int64_t> values) {
  std::string bytes = ArrayHeader(kBigintType, values.size());
  for (const int64_t value : values) {
    AppendInt32(bytes, sizeof(value));
    AppendInt64(bytes, value);
  }
  return Own(kBigintArrayType, std::move(bytes));
}

PgParameters& PgParameters::ByteStrings(std::span<const std::string_view> values) {
  std::string bytes = ArrayHeader(kByteaType, values.size());
  for (const std::string_view value : values) {
    AppendInt32(bytes, static_cast<uint32_t>(value.size()));
    bytes.append(value);
  }
  return Own(kByteaArrayType, std::move(bytes));
}

int64_t PgNumber(std::string_view field) {
  uint64_t wire = 0;
  if (field.size() == sizeof(wire)) std::memcpy(&wire, field.data(), sizeof(wire));
  return static_cast<int64_t>(be64toh(wire));
}

}  // namespace latticed
