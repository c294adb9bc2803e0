// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One stream of symbols, decoded alone: what the kernel's lanes do not cover, and the ends of those that they do.
#ifndef LATTICED_CLIENT_DECODER_SYMBOL_STREAM_H_
#define LATTICED_CLIENT_DECODER_SYMBOL_STREAM_H_

#include <cstdint>

#include "client/decoder/byte_reader.h"
#include "client/decoder/symbol_table.h"
#include "core/codec/rans_model.h"

namespace latticed::decoder {

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

// Calls visit(symbol) for each symbol of the coded bytes, by a wide table. False if visit is, or if they do not end where they
// began.
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

// Symbols that are coded: their table, and the bytes of the states.
struct CodedSymbols {
  TableKind kind = TableKind::kBad;
  uint32_t largest = 0;  // that may occur
  const uint8_t* begin = nullptr;
  const uint8_t* end = nullptr;
};
// Reads a table, of symbols below `end_symbol`, the number of bytes, and skips them. As ReadTable.
[[nodiscard]] inline CodedSymbols ReadCoded(ByteReader& in, int precision, uint32_t end_symbol,
                                            NarrowTable* narrow, WideTable* wide) {
  CodedSymbols coded;
  coded.kind = ReadTable(in, precision, end_symbol, narrow, wide, &coded.largest);
  if (coded.kind == TableKind::kBad) return coded;
  const uint32_t bytes = in.Varint();
  coded.begin = in.Skip(bytes);
  if (coded.begin == nullptr) return {};
  coded.end = coded.begin + bytes;
  return coded;
}
// The same after the bit length that says the precision.
[[nodiscard]] inline CodedSymbols ReadRawCoded(ByteReader& in, uint32_t end_symbol,
                                               NarrowTable* narrow, WideTable* wide) {
  constexpr uint32_t kMostBitLength = 18;
  const uint32_t bit_length = in.Byte();
  if (bit_length == 0 || bit_length > kMostBitLength) return {};
  return ReadCoded(in, RansPrecision(static_cast<int>(bit_length)), end_symbol, narrow, wide);
}

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_SYMBOL_STREAM_H_
