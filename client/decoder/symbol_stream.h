// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One stream of symbols, decoded alone: what the kernel's lanes do not cover, and the ends of those that they do.
#ifndef LATTICED_CLIENT_DECODER_SYMBOL_STREAM_H_
#define LATTICED_CLIENT_DECODER_SYMBOL_STREAM_H_

#include <algorithm>
#include <cstdint>

#include "client/decoder/byte_reader.h"
#include "client/decoder/symbol_table.h"

namespace latticed::decoder {

inline constexpr uint32_t kPlain = 0, kCoded = 1;             // whether symbols are coded
inline constexpr uint32_t kSchemeTagged = 0, kSchemeRaw = 1;  // how

constexpr int PrecisionOf(uint32_t bit_length) {
  return static_cast<int>(std::clamp(3 * bit_length / 2, 12u, 20u));
}

// The state that a stream ends with, and how many bytes are before it.
struct RansStart {
  uint32_t state = 0;
  const uint8_t* at = nullptr;  // the byte before this is the next
};
// Reads the state that decoding begins with: one to four bytes at the stream's end. False if it is none.
inline bool StartRans(const uint8_t* begin, const uint8_t* end, int precision, RansStart* start) {
  if (begin == end) return false;
  const uint32_t count = (end[-1] >> 6) + 1u;
  if (static_cast<size_t>(end - begin) < count) return false;
  uint32_t word = 0;
  for (uint32_t byte = 0; byte < count; ++byte)
    word |= uint32_t{end[-1 - static_cast<int>(byte)]} << (8 * (count - 1 - byte));
  word &= static_cast<uint32_t>((uint64_t{1} << (8 * count - 2)) - 1);
  start->state = word + (4u << precision);
  start->at = end - count;
  return start->state < 1024u << precision;
}

// Calls visit(symbol) for each symbol of the coded bytes. False if visit is, or if they do not end where they began.
template <class Visit>
bool DecodeWideStates(const uint8_t* begin, const uint8_t* end, uint32_t count,
                      const WideTable& table, const Visit& visit) {
  const uint32_t slots = 1u << table.precision, least = 4u << table.precision;
  RansStart start;
  if (!StartRans(begin, end, table.precision, &start)) return false;
  auto [state, at] = start;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t slot = state & (slots - 1), rank = table.rank[slot];
    state = table.probability[rank] * (state >> table.precision) + slot - table.cumulative[rank];
    while (state < least && at != begin) state = state << 8 | *--at;
    if (state < least || !visit(table.symbol[rank])) return false;
  }
  return state == least && at == begin;
}

// The same for bit length, table, length and states.
template <class Visit>
bool DecodeWide(ByteReader& in, uint32_t end_symbol, uint32_t count, WideTable* table,
                const Visit& visit) {
  const uint32_t bit_length = in.Byte();
  if (bit_length == 0 || bit_length > 18) return false;
  uint32_t largest = 0;
  if (ReadTable(in, PrecisionOf(bit_length), end_symbol, nullptr, table, &largest) !=
      TableKind::kWide) {
    return false;
  }
  const uint32_t bytes = in.Varint();
  const uint8_t* const begin = in.Skip(bytes);
  return begin != nullptr && DecodeWideStates(begin, begin + bytes, count, *table, visit);
}

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_SYMBOL_STREAM_H_
