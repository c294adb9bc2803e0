// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the device's meshopt streams with the host's, byte for byte. Stock decoders check the host's streams
// (tests/core/codec/).
#include "cuda/meshopt/meshopt_coder.h"

#include <algorithm>
#include <random>

#include "core/base/limits.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/cuda/streams/stream_coder_test.h"

namespace latticed::testing {
namespace {

class MeshoptCoderTest : public StreamCoderTest {
 protected:
  absl::StatusOr<DeviceStreamWriter> WriterFor(std::span<const Chunk> chunks) {
    return WriterWith(std::make_unique<MeshoptCoder>(chunks.front().normal_bits));
  }
  static void ExpectTheHostsBytes(const Chunk& chunk, const SharedBytes& got) {
    const std::vector<uint8_t> expected = EncodeMeshopt(chunk.vertices());
    ASSERT_TRUE(std::ranges::equal(got.span(), expected))
        << chunk.points << " points, " << chunk.position_bits << " and " << chunk.normal_bits
        << " bits: " << got.size << " bytes for " << expected.size() << ", seed " << kSeed;
  }
  // Encodes those of `chunks` that `numbers` names, with both writers.
  void ExpectTheHostsBytes(std::span<const Chunk> chunks, std::span<const uint32_t> numbers) {
    const auto vertices = Upload(chunks);
    ASSERT_OK_AND_ASSIGN(auto writer, WriterFor(chunks));
    std::vector<SharedBytes> results(numbers.size());
    ASSERT_OK(writer.Encode(vertices.span(), PlacesOf(chunks, numbers), 1, {}, results));
    for (size_t i = 0; i < numbers.size(); ++i) {
      ExpectTheHostsBytes(chunks[numbers[i]], results[i]);
      if (HasFatalFailure()) FAIL() << "chunk " << numbers[i];
    }
  }
  void ExpectTheHostsBytes(std::span<const Chunk> chunks) {
    ExpectTheHostsBytes(chunks, All(chunks));
  }
};

// Each size with each kind of data, at all places that odd numbers of points lead to.
TEST_F(MeshoptCoderTest, AllSizesUpToMoreThanABlock) {
  std::vector<size_t> sizes;
  for (size_t points = 1; points <= 300; ++points) sizes.push_back(points);
  for (const auto& [position_bits, normal_bits] : {std::pair(12, 8), {16, 0}, {14, 10}}) {
    ExpectTheHostsBytes(ChunksOf(sizes, position_bits, normal_bits));
    if (HasFatalFailure()) return;
  }
}

TEST_F(MeshoptCoderTest, AllPairsOfBits) {
  constexpr size_t kSizes[] = {2112, 1025, 511, 97};
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : {0, 6, 7, 8, 9, 10, 11, 12}) {
      ExpectTheHostsBytes(ChunksOf(kSizes, position_bits, normal_bits));
      if (HasFatalFailure()) return;
    }
  }
}

// Whole chunks, as in a scene.
TEST_F(MeshoptCoderTest, EveryNumberOfSegments) {
  for (int segments = limits::kMinSegments; segments <= limits::kMaxSegments; ++segments) {
    const int points = limits::kPatchesPerChunk * PointsPerPatch(segments);
    ExpectTheHostsBytes(AllKinds(static_cast<size_t>(points), 12, 8));
    if (HasFatalFailure()) FAIL() << segments << " segments";
  }
}

TEST_F(MeshoptCoderTest, TheLargestChunk) {
  constexpr size_t kSizes[] = {65'535, 3, 65'281, 65'280};
  for (const int normal_bits : {0, 8, 12}) {
    ExpectTheHostsBytes(ChunksOf(kSizes, 16, normal_bits));
    if (HasFatalFailure()) return;
  }
}

TEST_F(MeshoptCoderTest, SomeOfTheChunksInAnyOrder) {
  std::mt19937 random(kSeed);
  std::vector<Chunk> chunks;
  for (unsigned i = 0; i < 300; ++i) {
    const size_t points = 1 + random() % (i % 16 == 0 ? 2500 : 130);
    const Data data = kAllData[random() % std::size(kAllData)];
    chunks.push_back(MakeChunk(points, 14, 8, data, kSeed + i));
  }
  std::vector<uint32_t> numbers = All(chunks);
  std::ranges::shuffle(numbers, random);
  numbers.resize(200);
  ExpectTheHostsBytes(chunks, numbers);
}

TEST_F(MeshoptCoderTest, WhatTheCallerHasIsNotWritten) {
  std::vector<Chunk> chunks = AllKinds(2112, 12, 8);
  ASSERT_OK_AND_ASSIGN(auto writer, WriterFor(chunks));
  std::vector<VertexDigest> digests(chunks.size());
  const auto expect_written = [&](const std::vector<uint32_t>& expected) {
    const auto vertices = Upload(chunks);
    std::vector<SharedBytes> results(chunks.size());
    ASSERT_OK(writer.Encode(vertices.span(), PlacesOf(chunks, All(chunks)), 1, digests, results));
    std::vector<uint32_t> written;
    for (const uint32_t i : All(chunks)) {
      if (results[i].data == nullptr) continue;
      written.push_back(i);
      ASSERT_NO_FATAL_FAILURE(ExpectTheHostsBytes(chunks[i], results[i]));
    }
    EXPECT_EQ(written, expected);
  };
  ASSERT_NO_FATAL_FAILURE(expect_written(All(chunks)));
  ASSERT_NO_FATAL_FAILURE(expect_written({}));
  chunks[3].bytes[4222] ^= 1;       // the last x
  chunks.back().bytes.back() ^= 1;  // the last t
  ASSERT_NO_FATAL_FAILURE(expect_written({3, 14}));
}

// A writer guesses the room for its streams from those before.
TEST_F(MeshoptCoderTest, StreamsAreWholeWhereTheyTakeMoreOrLessThanTheLastOnes) {
  std::vector<Chunk> small, large, mixed;
  for (unsigned i = 0; i < 40; ++i) {
    small.push_back(MakeChunk(597, 14, 8, Data::kConstant, kSeed + i));
    large.push_back(MakeChunk(597, 14, 8, Data::kRandom, kSeed + i));
    mixed.push_back(i % 8 == 0 ? large.back() : small.back());
  }
  ASSERT_OK_AND_ASSIGN(auto writer, WriterFor(small));
  for (const auto& chunks : {small, large, large, mixed, large, small, small}) {
    const auto vertices = Upload(chunks);
    std::vector<SharedBytes> results(chunks.size());

    ASSERT_OK(writer.Encode(vertices.span(), PlacesOf(chunks, All(chunks)), 1, {}, results));

    for (size_t i = 0; i < chunks.size(); ++i) {
      ASSERT_NO_FATAL_FAILURE(ExpectTheHostsBytes(chunks[i], results[i]));
    }
  }
}

TEST_F(MeshoptCoderTest, NothingToEncode) {
  ASSERT_OK_AND_ASSIGN(auto writer, WriterWith(std::make_unique<MeshoptCoder>(8)));
  EXPECT_OK(writer.Encode({}, {}, 1, {}, {}));
}

}  // namespace
}  // namespace latticed::testing
