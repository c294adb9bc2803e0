// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The probabilities of one stream of symbols, by the rules of rans_shares.h, and their bytes:
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
#include <vector>

#include "core/codec/byte_writer.h"

namespace latticed {

class RansTable {
 public:
  // Makes room for `most_symbols` distinct ones and the padding of draco_kernel::CollectCounts.
  void Reserve(size_t most_symbols);

  // Adds up `count` histograms, which lie `stride` apart, and makes the table from them. No symbol from `end` on
  // occurs, and at least one below does; `end` must have been reserved. The histograms are zero afterwards. They are
  // padded as CollectCounts says.
  void Build(std::vector<uint32_t>& histograms, size_t count, size_t stride, size_t end);

  // The result of RansBitLength. If it is 0, there are no probabilities.
  int bit_length() const { return bit_length_; }
  int precision() const { return precision_; }
  uint32_t largest() const { return symbols_[distinct_ - 1]; }

  // Calls visit(symbol, probability, cumulative) for the symbols that occur, ascending.
  template <class Visit>
  void ForEach(const Visit& visit) const {
    uint32_t cumulative = 0;
    for (size_t i = 0; i < distinct_; ++i) {
      visit(symbols_[i], probabilities_[i], cumulative);
      cumulative += probabilities_[i];
    }
  }

  void Write(ByteWriter& out) const;
  size_t MostBytes() const;
  size_t MemoryBytes() const {
    return (symbols_.capacity() + counts_.capacity() + probabilities_.capacity()) *
           sizeof(uint32_t);
  }

 private:
  void ShareOut();

  int bit_length_ = 0, precision_ = 0;
  size_t distinct_ = 0;
  std::vector<uint32_t> symbols_, counts_, probabilities_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_RANS_TABLE_H_
