// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rans_table.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "core/codec/draco_kernel.h"
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

void RansTable::Reserve(size_t most_symbols) {
  const size_t room = most_symbols + draco_kernel::kPadding;
  if (symbols_.size() >= room) return;
  for (std::vector<uint32_t>* values : {&symbols_, &counts_, &probabilities_}) {
    values->reserve(room);  // no more than asked for
    values->resize(room);
  }
}

void RansTable::Build(std::vector<uint32_t>& histograms, size_t count, size_t stride, size_t end) {
  distinct_ = draco_kernel::CollectCounts(histograms.data(), count, stride, end, symbols_.data(),
                                          counts_.data());
  bit_length_ = RansBitLength(static_cast<uint32_t>(distinct_));
  precision_ = RansPrecision(bit_length_);
  if (bit_length_ != 0) ShareOut();
}

void RansTable::ShareOut() {
  const std::span<const uint32_t> counts = std::span(counts_).first(distinct_);
  uint32_t threshold = 0, lifted = 0, rest = std::accumulate(counts.begin(), counts.end(), 0u);
  while (!IsRansThreshold(threshold, lifted, rest, precision_)) {
    ++threshold;
    const auto more = static_cast<uint32_t>(std::count(counts.begin(), counts.end(), threshold));
    lifted += more;
    rest -= more * threshold;
  }
  const uint64_t scale = RansScale(lifted, rest, precision_);
  uint32_t before = 0, given = 0;
  size_t last = 0;
  for (size_t i = 0; i < distinct_; ++i) {
    if (counts[i] <= threshold) {
      probabilities_[i] = 1;
      continue;
    }
    before += counts[i];
    probabilities_[i] = RansProbability(RansBoundary(scale, before) - given, counts[i]);
    given += probabilities_[i];
    last = i;
  }
  probabilities_[last] += RansBoundary(scale, rest) - given;
}

size_t RansTable::MostBytes() const {
  // Three a probability, and a byte of zeros before it for each 64.
  return kMostVarintBytes + 4 * distinct_ + largest() / kMostZeros;
}

void RansTable::Write(ByteWriter& out) const {
  out.Varint(largest() + uint64_t{1});
  uint32_t next = 0;
  ForEach([&](uint32_t symbol, uint32_t probability, uint32_t) {
    WriteZeros(symbol - next, out);
    WriteProbability(probability, out);
    next = symbol + 1;
  });
}

}  // namespace latticed
