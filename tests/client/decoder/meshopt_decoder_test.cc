// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The decoder of meshopt chunks against the integers that our writer was given, under each instruction set. On damaged
// streams all instruction sets agree, and nothing is written beside the slice; meshoptimizer's verdict on such streams is
// compared in tests/client/web/decode/meshopt_test.ts.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <vector>

#include "client/decoder/chunk_decoder.h"
#include "client/decoder/meshopt/meshopt_kernel.h"
#include "core/codec/meshopt/meshopt_format.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/instruction_sets.h"

namespace latticed::decoder {
namespace {

using latticed::testing::AllTargets;
using latticed::testing::ChosenTarget;
using latticed::testing::Chunk;
using latticed::testing::Data;
using latticed::testing::kAllData;
using latticed::testing::MakeChunk;
using Stream = std::vector<uint8_t>;

constexpr size_t kGuardNumbers = 16;
constexpr uint16_t kGuardNumber = 0xA55A;

struct MeshoptChunk {
  ChunkJob job;
  std::vector<uint16_t> numbers;
};

MeshoptChunk DecodeChunk(int position_bits, int normal_bits, const Stream& stream, size_t points) {
  MeshoptChunk decoded{
      {}, std::vector<uint16_t>(points * kNumbersPerPoint + kGuardNumbers, kGuardNumber)};
  decoded.job = {
      .stream = stream, .points = static_cast<uint32_t>(points), .out = decoded.numbers.data()};
  ChunkDecoder().Decode({position_bits, normal_bits, Codec::kMeshopt}, {&decoded.job, 1});
  EXPECT_TRUE(std::all_of(decoded.numbers.end() - kGuardNumbers, decoded.numbers.end(),
                          [](uint16_t n) { return n == kGuardNumber; }));
  decoded.numbers.resize(points * kNumbersPerPoint);
  return decoded;
}

std::vector<uint16_t> NumbersOf(const Chunk& chunk) {
  std::vector<uint16_t> numbers;
  const auto add = [&](uint32_t number) { numbers.push_back(static_cast<uint16_t>(number)); };
  const DecodedIntegers& integers = chunk.integers;
  for (size_t i = 0; i < chunk.points; ++i) {
    for (size_t axis = 0; axis < 3; ++axis) add(integers.positions[3 * i + axis]);
    add(0);
    for (size_t c = 0; c < 2; ++c) add(integers.normals.empty() ? 0 : integers.normals[2 * i + c]);
  }
  return numbers;
}

TEST(MeshoptDecoderTest, DecodesWhatTheWriterWrites) {
  unsigned seed = 1;
  for (const size_t points : {1u, 2u, 15u, 16u, 17u, 66u, 255u, 256u, 257u, 2112u}) {
    for (int position_bits = 8; position_bits <= 16; position_bits += 2) {
      for (const int normal_bits : {0, 6, 8, 9, 12}) {
        for (const Data data : kAllData) {
          const Chunk chunk = MakeChunk(points, position_bits, normal_bits, data, seed++);
          const Stream stream = EncodeMeshopt(chunk.vertices());
          const std::vector<uint16_t> expected = NumbersOf(chunk);
          for (const int64_t target : AllTargets()) {
            const ChosenTarget chosen(target);
            const MeshoptChunk decoded = DecodeChunk(position_bits, normal_bits, stream, points);
            ASSERT_TRUE(decoded.job.decoded && decoded.numbers == expected)
                << meshopt_kernel::TargetName() << ", seed " << seed - 1;
            for (size_t axis = 0; axis < 3; ++axis) {
              uint16_t low = 0xffff, high = 0;
              for (size_t i = axis; i < expected.size(); i += kNumbersPerPoint) {
                low = std::min(low, expected[i]);
                high = std::max(high, expected[i]);
              }
              ASSERT_EQ(decoded.job.least[axis], low);
              ASSERT_EQ(decoded.job.most[axis], high);
            }
          }
        }
      }
    }
  }
}

TEST(MeshoptDecoderTest, DecodesTheLargestChunk) {
  const Chunk chunk = MakeChunk(kMostPoints, 12, 8, Data::kWalk, 3);
  const MeshoptChunk decoded = DecodeChunk(12, 8, EncodeMeshopt(chunk.vertices()), kMostPoints);
  EXPECT_TRUE(decoded.job.decoded);
  EXPECT_EQ(decoded.numbers, NumbersOf(chunk));
}

TEST(MeshoptDecoderTest, RefusesAnotherForm) {
  // Extreme, so that all bits are in use.
  Stream stream = EncodeMeshopt(MakeChunk(66, 12, 8, Data::kExtreme, 1).vertices());
  const auto is_decoded = [&](int position_bits, int normal_bits, size_t points) {
    return DecodeChunk(position_bits, normal_bits, stream, points).job.decoded;
  };
  ASSERT_TRUE(is_decoded(12, 8, 66));
  EXPECT_FALSE(is_decoded(11, 8, 66));
  EXPECT_FALSE(is_decoded(12, 7, 66));
  EXPECT_FALSE(is_decoded(12, 9, 66));  // its differences have 16 bits
  EXPECT_FALSE(is_decoded(12, 0, 66));
  EXPECT_FALSE(is_decoded(12, 8, 80));
  EXPECT_FALSE(is_decoded(12, 8, 0));
  EXPECT_FALSE(is_decoded(12, 8, size_t{kMostPoints} + 1));
  stream.push_back(0);
  EXPECT_FALSE(is_decoded(12, 8, 66));
  for (size_t size = 0; size < stream.size() - 1; ++size) {
    EXPECT_FALSE(DecodeChunk(12, 8, Stream(stream.data(), stream.data() + size), 66).job.decoded);
  }
}

// Bytes of a vertex that are 0 in every view of the form, and the padding, which meshoptimizer ignores.
TEST(MeshoptDecoderTest, RefusesNumbersWhereNoneAre) {
  const Stream good = EncodeMeshopt(MakeChunk(1, 12, 8, Data::kConstant, 1).vertices());
  const size_t baseline = good.size() - meshopt_format::kChannels - meshopt_format::kVertexBytes;
  ASSERT_TRUE(DecodeChunk(12, 8, good, 1).job.decoded);
  for (const size_t place : {baseline + 6, baseline + 7, baseline + 9, baseline + 11, baseline - 1,
                             good.size() - 1, good.size() - 2, size_t{0}, size_t{1}, size_t{3}}) {
    Stream bad = good;
    bad[place] ^= 2;
    EXPECT_FALSE(DecodeChunk(12, 8, bad, 1).job.decoded) << "byte " << place;
  }
}

TEST(MeshoptDecoderTest, InstructionSetsAgreeOnDamagedStreams) {
  const unsigned seed = std::random_device{}();
  std::cout << "seed " << seed << "\n";
  std::mt19937 random(seed);
  size_t accepted = 0;
  for (unsigned round = 0; round < 4000; ++round) {
    const int position_bits = round % 2 == 0 ? 12 : 16;
    const int normal_bits = round % 3 == 0 ? 0 : round % 3 == 1 ? 8 : 12;
    const size_t points = 1 + random() % 400;
    Stream stream = EncodeMeshopt(MakeChunk(points, position_bits, normal_bits,
                                            kAllData[random() % std::size(kAllData)], round)
                                      .vertices());
    for (unsigned flip = 0; flip <= round % 3; ++flip) {
      stream[random() % stream.size()] ^= static_cast<uint8_t>(1u << random() % 8);
    }
    if (random() % 8 == 0) stream.resize(random() % stream.size());
    std::vector<MeshoptChunk> all;
    for (const int64_t target : AllTargets()) {
      const ChosenTarget chosen(target);
      all.push_back(DecodeChunk(position_bits, normal_bits, stream, points));
      ASSERT_EQ(all.back().job.decoded, all.front().job.decoded)
          << meshopt_kernel::TargetName() << ", round " << round;
      if (!all.front().job.decoded) continue;
      ASSERT_EQ(all.back().numbers, all.front().numbers)
          << meshopt_kernel::TargetName() << ", round " << round;
    }
    if (all.front().job.decoded) ++accepted;
  }
  std::cout << accepted << " of 4000 accepted\n";
}

}  // namespace
}  // namespace latticed::decoder
