// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rans_table.h"

#include <gtest/gtest.h>

#include <random>

#include "core/codec/draco_kernel.h"
#include "core/codec/rans_encoder.h"
#include "core/codec/rans_model.h"

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

// Every symbol that occurs has a probability, in ascending order, and they sum up to M.
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

TEST(RansModel, TwelveBitsUpTo2048SymbolsThenTheLeastThatIsLegal) {
  const struct {
    uint32_t distinct;
    int precision;
  } cases[] = {{1, 12},      {2048, 12},   {2049, 13},   {4096, 13},    {4097, 15},   {16'384, 15},
               {16'385, 16}, {32'768, 16}, {32'769, 18}, {131'073, 19}, {524'288, 20}};
  for (const auto& c : cases) {
    EXPECT_EQ(RansPrecision(RansBitLength(c.distinct)), c.precision) << c.distinct;
  }
  EXPECT_EQ(RansBitLength(524'289), 0);
}

TEST(RansTable, ProbabilitiesSumUp) {
  constexpr unsigned kSeed = 17;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 300; ++round) {
    SCOPED_TRACE(::testing::Message() << "seed " << kSeed << " round " << round);
    // From flat to steep, from a few symbols to more than 2,048.
    std::vector<uint32_t> counts(1 + random() % (round % 10 == 0 ? 9000 : 300));
    const uint32_t top = 1u << (random() % 14);
    for (uint32_t& count : counts) count = random() % 3 == 0 ? 0 : random() % (random() % top + 1);
    ++counts.back();
    ExpectLegal(counts);
  }
  ExpectLegal({1});
  ExpectLegal({196'605});
  ExpectLegal(std::vector<uint32_t>(2048, 1));
  ExpectLegal(std::vector<uint32_t>(65'536, 3));
  std::vector<uint32_t> steep(2048, 1);
  steep[7] = 190'000;
  ExpectLegal(steep);
}

// By hand: 3 : 1 of 4,096; two symbols lifted to 1.
TEST(RansTable, SharesByCounts) {
  std::vector<uint32_t> probabilities;
  const auto keep = [&](uint32_t, uint32_t probability, uint32_t) {
    probabilities.push_back(probability);
  };
  TableOf({300, 0, 100}).ForEach(keep);
  EXPECT_EQ(probabilities, (std::vector<uint32_t>{3072, 1024}));
  probabilities.clear();
  TableOf({1, 40'000, 1}).ForEach(keep);
  EXPECT_EQ(probabilities, (std::vector<uint32_t>{1, 4094, 1}));
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
    const uint64_t multiple = uint64_t{random() % 1024} * p;  // the hardest are beside multiples
    expect_exact(p, multiple);
    expect_exact(p, multiple + p - 1);
  }
}

}  // namespace
}  // namespace latticed
