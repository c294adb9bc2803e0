// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rans_table.h"

#include "core/codec/rans_model.h"

namespace latticed {
namespace {

constexpr uint32_t kMostZeros = 64;  // in one byte

void WriteZeros(uint32_t zeros, ByteWriter& out) {
  for (; zeros > 0; zeros -= std::min(zeros, kMostZeros)) {
    out.Byte((std::min(zeros, kMostZeros) - 1) << 2 | 3);
  }
}

void WriteProbability(uint32_t probability, ByteWriter& out) {
  const uint32_t more_bytes = probability < 1u << 6 ? 0 : probability < 1u << 14 ? 1 : 2;
  out.Byte((probability & 63) << 2 | more_bytes);
  for (uint32_t b = 0; b < more_bytes; ++b) out.Byte(probability >> (6 + 8 * b));
}

}  // namespace

void RansTable::Build(std::span<uint32_t> counts) {
  symbols_.clear();
  uint32_t total = 0;
  for (uint32_t s = 0; s < counts.size(); ++s) {
    if (counts[s] == 0) continue;
    symbols_.push_back({.symbol = s, .count = counts[s]});
    total += counts[s];
    counts[s] = 0;
  }
  bit_length_ = RansBitLength(static_cast<uint32_t>(symbols_.size()));
  precision_ = RansPrecision(bit_length_);
  if (bit_length_ != 0) ShareOut(total);
}

void RansTable::ShareOut(uint32_t total) {
  uint32_t threshold = 0, lifted = 0, rest = total;
  while (!IsRansThreshold(threshold, lifted, rest, precision_)) {
    ++threshold;
    for (const Symbol& s : symbols_) {
      if (s.count != threshold) continue;
      ++lifted;
      rest -= threshold;
    }
  }
  const uint64_t scale = RansScale(lifted, rest, precision_);
  uint32_t before = 0, boundary = 0, cumulative = 0;
  for (Symbol& s : symbols_) {
    s.probability = 1;
    if (s.count > threshold) {
      before += s.count;
      const uint32_t next = RansBoundary(scale, before);
      s.probability = next - boundary;
      boundary = next;
    }
    s.cumulative = cumulative;
    cumulative += s.probability;
  }
}

size_t RansTable::MostBytes() const {
  // Three a probability, and a byte of zeros before it for each 64.
  return kMostVarintBytes + 4 * symbols_.size() + symbols_.back().symbol / kMostZeros;
}

void RansTable::Write(ByteWriter& out) const {
  out.Varint(symbols_.back().symbol + uint64_t{1});
  uint32_t next = 0;
  for (const Symbol& s : symbols_) {
    WriteZeros(s.symbol - next, out);
    WriteProbability(s.probability, out);
    next = s.symbol + 1;
  }
}

}  // namespace latticed
