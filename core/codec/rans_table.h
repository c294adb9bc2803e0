// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The probabilities of one stream of symbols, by the rules of rans_model.h, and their bytes:
//
//   varint (largest symbol + 1), then for each symbol from 0 on, two low bits first:
//   k = 0 … 2 and the probability in 8 (k + 1) - 2 bits, or 3 and how many more symbols than this
//   one have probability 0, 63 at most
//
// Threads  a table is used by one thread at a time
#ifndef LATTICED_CORE_CODEC_RANS_TABLE_H_
#define LATTICED_CORE_CODEC_RANS_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/codec/byte_writer.h"

namespace latticed {

class RansTable {
 public:
  struct Symbol {
    uint32_t symbol, count, probability, cumulative;
  };

  // counts[s]: how often s occurs; the last is not zero. All are zero afterwards.
  void Build(std::span<uint32_t> counts);

  // Of RansBitLength. Without one there are no probabilities.
  int bit_length() const { return bit_length_; }
  int precision() const { return precision_; }
  // Ascending; those that occur.
  std::span<const Symbol> symbols() const { return symbols_; }

  void Write(ByteWriter& out) const;
  size_t MostBytes() const;

 private:
  void ShareOut(uint32_t total);

  int bit_length_ = 0, precision_ = 0;
  std::vector<Symbol> symbols_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_RANS_TABLE_H_
