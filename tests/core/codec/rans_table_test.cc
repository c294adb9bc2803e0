// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rans_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/codec/draco_kernel.h"
#include "core/codec/rans_encoder.h"

namespace latticed {
namespace {

RansTable TableOf(std::vector<uint32_t> counts) {
  const size_t end = counts.size();
  counts.resize(end + draco_kernel::kPadding);
  RansTable table;
  table.Reserve(end);
  table.Build(counts, 1, counts.size(), end);
  for (const uint32_t count : counts) EXPECT_EQ(count, 0u);
  return table;
}

// Every symbol that occurs has a probability, in ascending order, and the probabilities sum to M.
void ExpectLegal(const std::vector<uint32_t>& counts) {
  const RansTable table = TableOf(counts);
  ASSERT_NE(table.bit_length(), 0);
  uint32_t next = 0, sum = 0;
  table.ForEach([&](uint32_t symbol, uint32_t probability, uint32_t cumulative) {
    for (; next < symbol; ++next) EXPECT_EQ(counts[next], 0u);
    EXPECT_GT(counts[symbol], 0u);
    EXPECT_GT(probability, 0u);
    EXPECT_EQ(cumulative, sum);
    sum += probability;
    next = symbol + 1;
  });
  EXPECT_EQ(next, counts.size());
  EXPECT_EQ(sum, 1u << table.precision());
}

TEST(RansTable, ProbabilitiesSumUp) {
  constexpr unsigned kSeed = 17;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 300; ++round) {
    SCOPED_TRACE(::testing::Message() << "seed " << kSeed << " round " << round);
    // Counts from flat to steep, and from a few symbols to more than 2,048.
    std::vector<uint32_t> counts(1 + random() % (round % 10 == 0 ? 9000 : 300));
    const uint32_t top = 1u << (random() % 14);
    for (uint32_t& count : counts) count = random() % 3 == 0 ? 0 : random() % (random() % top + 1);
    ++counts.back();
    ExpectLegal(counts);
  }
}

// Numbers of symbols at, around and between the limits of each precision. All are equally frequent,
// or one is far more so.
TEST(RansTable, ProbabilitiesOfExtremeCountsSumUp) {
  for (const uint32_t count : {1u, 2u, 3u, 63u, 196'605u, 0x7FFFFFFFu, 0xFFFFFFFFu}) {
    SCOPED_TRACE(::testing::Message() << "one symbol, " << count);
    ExpectLegal({count});
  }
  for (const size_t distinct : {2u, 3u, 7u, 48u, 63u, 64u, 65u, 66u, 2047u, 2048u, 2049u, 4096u,
                                4097u, 16'384u, 16'385u, 32'768u, 65'536u}) {
    for (const uint32_t count : {1u, 2u, 3u, 99u, 1000u}) {
      SCOPED_TRACE(::testing::Message() << distinct << " symbols, each " << count);
      std::vector<uint32_t> counts(distinct, count);
      ExpectLegal(counts);
      for (const size_t often : {size_t{0}, distinct / 2, distinct - 1}) {
        for (const uint32_t times : {count + 1, 196'605u, 3'000'000'000u}) {
          counts.assign(distinct, count);
          counts[often] = times;
          ExpectLegal(counts);
        }
      }
    }
  }
}

// The bits that a symbol takes in the table and in the stream.
double BitsOf(uint32_t count, double probability, int precision) {
  const double bytes = probability < 64 ? 1 : probability < 16'384 ? 2 : 3;
  return 8 * bytes + count * (precision - std::log2(probability));
}
// The same with the best probability if each unit of probability costs `price` bits, these
// included. M <= 2^14.
double LeastBitsAt(double price, uint32_t count, int precision) {
  const double best = std::clamp(count / std::log(2.0) / price, 1.0, std::exp2(precision));
  double least = 1e300;
  for (const double p : {std::floor(best), std::ceil(best), std::min(std::floor(best), 63.0)}) {
    least = std::min(least, BitsOf(count, p, precision) + price * p);
  }
  return least;
}

// A lower bound for all probabilities that sum to M, for any price (Lagrange). Returns the best
// over some prices.
double LeastBits(const std::vector<uint32_t>& counts, int precision) {
  const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
  double least = 0;
  for (double factor = 0.8; factor < 1.25; factor *= 1.001) {
    const double price = factor * total / std::log(2.0) / std::exp2(precision);
    double bits = -price * std::exp2(precision);
    for (const uint32_t count : counts) {
      if (count > 0) bits += LeastBitsAt(price, count, precision);
    }
    least = std::max(least, bits);
  }
  return least;
}

TEST(RansTable, TakesNoByteMoreThanAnyProbabilities) {
  constexpr unsigned kSeed = 29;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 40; ++round) {
    // Mostly small steps, and jumps between patches.
    std::geometric_distribution<uint32_t> step(0.002 + 0.0075 * round);
    std::vector<uint32_t> counts(4096);
    for (int i = 0; i < 6336; ++i) {
      ++counts[i % 66 == 0 ? random() % 4096 : std::min(step(random), 4095u)];
    }
    const RansTable table = TableOf(counts);
    double bits = 0;
    table.ForEach([&](uint32_t symbol, uint32_t probability, uint32_t) {
      bits += BitsOf(counts[symbol], probability, table.precision());
    });
    EXPECT_LE(bits, LeastBits(counts, table.precision()) + 8)
        << "seed " << kSeed << " round " << round;
  }
}

TEST(RansEncoder, DivisionByMultiplicationIsExact) {
  constexpr unsigned kSeed = 19;
  std::mt19937 random(kSeed);
  const auto expect_exact = [](uint32_t p, uint64_t x) {
    const RansEntry entry = MakeRansEntry(p, 0);
    ASSERT_EQ((x * entry.reciprocal) >> 50, x / p) << x << " / " << p;
  };
  for (int round = 0; round < 100'000; ++round) {
    const uint32_t p = 1 + random() % (1u << (random() % 21));
    const uint64_t multiple = uint64_t{random() % 1024} * p;  // the hardest are next to multiples
    expect_exact(p, multiple);
    expect_exact(p, multiple + p - 1);
  }
}

}  // namespace
}  // namespace latticed
