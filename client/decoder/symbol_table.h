// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads the probabilities of one stream of symbols (core/codec/rans_table.h has their bytes).
//
// Threads  a table is used by one thread at a time
#ifndef LATTICED_CLIENT_DECODER_SYMBOL_TABLE_H_
#define LATTICED_CLIENT_DECODER_SYMBOL_TABLE_H_

#include <cstdint>
#include <vector>

#include "client/decoder/byte_reader.h"
#include "client/decoder/lanes/narrow_table.h"

namespace latticed::decoder {

// Any table.
struct WideTable {
  int precision = 0;
  std::vector<uint32_t> rank;                             // by slot
  std::vector<uint32_t> symbol, cumulative, probability;  // by rank
};

enum class TableKind : uint8_t { kBad, kNarrow, kWide };

// Reads a table whose symbols are all below `end`, and sets the largest that occurs. Writes `narrow`, unless it is null or too
// small, else `wide`.
[[nodiscard]] TableKind ReadTable(ByteReader& in, int precision, uint32_t end, NarrowTable* narrow,
                                  WideTable* wide, uint32_t* largest);

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_SYMBOL_TABLE_H_
