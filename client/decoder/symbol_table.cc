// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/decoder/symbol_table.h"

#include <algorithm>
#include <cstring>

namespace latticed::decoder {
namespace {

constexpr int kMostPrecision = 20;  // the largest that there is

// Calls visit(symbol, probability) for the symbols that occur. False if the bytes are no table.
template <class Visit>
bool ForEachProbability(ByteReader& in, uint32_t end, const Visit& visit) {
  const uint32_t count = in.Varint();
  if (!in.ok() || count > end) return false;
  for (uint32_t symbol = 0; symbol < count;) {
    const uint32_t first = in.Byte();
    const uint32_t more = first & 3;
    if (more == 3) {
      symbol += (first >> 2) + 1;
      if (!in.ok() || symbol > count) return false;
      continue;
    }
    uint32_t probability = first >> 2;
    for (uint32_t byte = 0; byte < more; ++byte) probability |= in.Byte() << (8 * byte + 6);
    if (!in.ok() || (probability != 0 && !visit(symbol, probability))) return false;
    ++symbol;
  }
  return true;
}

}  // namespace

TableKind ReadTable(ByteReader& in, int precision, uint32_t end, NarrowTable* narrow,
                    WideTable* wide, uint32_t* largest) {
  if (precision > kMostPrecision) return TableKind::kBad;
  const uint32_t slots = 1u << precision;
  const ByteReader start = in;
  uint32_t ranks = 0, sum = 0;
  if (narrow != nullptr && precision == kNarrowPrecision) {
    const bool good = ForEachProbability(in, end, [&](uint32_t symbol, uint32_t probability) {
      if (probability > slots - sum || ranks == kNarrowSymbols) return false;
      std::memset(narrow->rank + sum, static_cast<int>(ranks), probability);
      narrow->cumulative[ranks] = uint64_t{sum} << kStateShift;
      narrow->complement[ranks] = uint64_t{slots - probability} << kStateShift;
      narrow->symbol[ranks] = static_cast<uint16_t>(symbol);
      *largest = symbol;
      ++ranks;
      sum += probability;
      return true;
    });
    if (good) return sum == slots ? TableKind::kNarrow : TableKind::kBad;
    if (ranks < kNarrowSymbols) return TableKind::kBad;
    in = start;
    ranks = sum = 0;
  }
  wide->precision = precision;
  wide->rank.resize(slots);
  wide->symbol.clear();
  wide->cumulative.clear();
  wide->probability.clear();
  const bool good = ForEachProbability(in, end, [&](uint32_t symbol, uint32_t probability) {
    if (probability > slots - sum) return false;
    std::fill_n(wide->rank.begin() + sum, probability, ranks);
    wide->symbol.push_back(symbol);
    wide->cumulative.push_back(sum);
    wide->probability.push_back(probability);
    *largest = symbol;
    ++ranks;
    sum += probability;
    return true;
  });
  return good && sum == slots ? TableKind::kWide : TableKind::kBad;
}

}  // namespace latticed::decoder
