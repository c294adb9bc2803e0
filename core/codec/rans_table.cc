// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rans_table.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "core/codec/draco_kernel.h"
#include "core/codec/rans_model.h"
#include "core/codec/rans_shares.h"

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
    values->reserve(room);  // resize alone might take more
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
  RansShares shares(std::accumulate(counts.begin(), counts.end(), 0u), precision_);
  while (shares.searching()) {
    uint32_t sum = 0, ones = 0;
    for (const uint32_t count : counts) {  // without branches: compilers vectorise it
      const uint32_t probability = shares.Probability(shares.scale(), count);
      sum += probability;
      ones += probability == 1;
    }
    shares.Try(sum, ones);
  }
  uint32_t left = 1u << precision_;
  for (size_t i = 0; i < distinct_; ++i) {
    probabilities_[i] = shares.Probability(shares.fits(), counts[i]);
    left -= probabilities_[i];
  }
  for (size_t i = 0; i < distinct_ && left > 0; ++i) {
    const uint32_t more = shares.Probability(shares.exceeds(), counts[i]) - probabilities_[i];
    if (more > left) break;
    probabilities_[i] += more;
    left -= more;
  }
  if (left == 0) return;
  const auto most_frequent = std::max_element(counts.begin(), counts.end());
  probabilities_[static_cast<size_t>(most_frequent - counts.begin())] += left;
}

size_t RansTable::MostBytes() const {
  // Three bytes per probability, one for zeros before it, and one for every 64 zeros.
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
