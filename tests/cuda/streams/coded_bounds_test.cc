// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Codes random symbols, and compares their bytes with the bounds. Few and many distinct symbols, even and skewed, short
// and long streams, so that tables of all precisions occur.
#include "cuda/draco/coded_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/codec/draco_kernel.h"
#include "core/codec/rans_encoder.h"
#include "core/codec/rans_model.h"
#include "core/codec/rans_table.h"

namespace latticed::kernels {
namespace {

constexpr unsigned kSeed = 20'261'127;

struct Coded {
  size_t bytes;         // of the states
  double bits;          // the sum of log2(M / p)
  double entropy_bits;  // the sum of log2(symbols / count)
  int precision;
};

Coded Code(const std::vector<uint32_t>& symbols, uint32_t end) {
  std::vector<uint32_t> counts(end + draco_kernel::kPadding);
  for (const uint32_t symbol : symbols) ++counts[symbol];
  Coded coded{};
  for (const uint32_t symbol : symbols) {
    coded.entropy_bits += std::log2(static_cast<double>(symbols.size()) / counts[symbol]);
  }
  RansTable table;
  table.Reserve(end);
  table.Build(counts, 1, end, end);
  coded.precision = table.precision();
  std::vector<RansEntry> entries(end);
  table.ForEach([&](uint32_t symbol, uint32_t probability, uint32_t cumulative) {
    entries[symbol] = MakeRansEntry(probability, cumulative);
  });
  std::vector<uint8_t> states(MostRansBytes(symbols.size(), coded.precision));
  RansEncoder encoder(coded.precision, states.data());
  for (size_t i = symbols.size(); i-- > 0;) {
    const RansEntry& entry = entries[symbols[i]];
    encoder.Put(entry);
    coded.bits += coded.precision - std::log2(entry.probability);
  }
  coded.bytes = static_cast<size_t>(encoder.Finish() - states.data());
  return coded;
}

TEST(CodedBounds, HoldForSymbolsOfAnyDistribution) {
  std::mt19937 random(kSeed);
  int least_precision = kMostRansPrecision, most_precision = 0;
  for (int i = 0; i < 4'000; ++i) {
    const uint32_t end = 1u << (i % 17), count = 1 + random() % (i % 8 == 0 ? 60'000 : 400);
    const double skew = 1 + random() % 8;
    std::vector<uint32_t> symbols(count);
    for (uint32_t& symbol : symbols) {
      const double share = std::pow(std::uniform_real_distribution<>(0, 1)(random), skew);
      symbol = std::min(end - 1, static_cast<uint32_t>(share * end));
    }
    const Coded coded = Code(symbols, end);
    ASSERT_LE(LeastCodedBytes(static_cast<float>(coded.bits), count), coded.bytes)
        << "end " << end << ", count " << count << ", skew " << skew << ", seed " << kSeed;
    ASSERT_LE(LeastCodedBytes(static_cast<float>(coded.entropy_bits), count), coded.bytes);
    ASSERT_GE(MostCodedBytes(static_cast<float>(coded.bits), count), coded.bytes)
        << "end " << end << ", count " << count << ", skew " << skew << ", seed " << kSeed;
    // They are of use: within a byte a symbol of each other, and mostly far closer.
    ASSERT_LE(MostCodedBytes(static_cast<float>(coded.bits), count),
              LeastCodedBytes(static_cast<float>(coded.bits), count) + count / 12 + 4);
    least_precision = std::min(least_precision, coded.precision);
    most_precision = std::max(most_precision, coded.precision);
  }
  EXPECT_EQ(least_precision, kLeastRansPrecision);
  EXPECT_GE(most_precision, 16);
}

}  // namespace
}  // namespace latticed::kernels
