// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Our writer as a server calls it: for a group of chunks, whose states the vector code advances in
// lockstep. Under each instruction set, every stream must have the same bytes as the chunk written
// alone with a single state, and libdraco must decode it to the integers that went in. Further
// tests: the writer survives any values, and takes no more bytes than libdraco.
#include <algorithm>
#include <array>
#include <set>
#include <span>

#include "core/codec/draco_kernel.h"
#include "core/codec/draco_writer.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/holds_integers.h"
#include "tests/support/instruction_sets.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr unsigned kWriterSeed = 47;
constexpr size_t kFull = draco_kernel::kLanes;
constexpr std::array kAllNormalBits{0, 6, 7, 8, 9, 10, 11, 12};

using Stream = std::vector<uint8_t>;

struct Shape {
  size_t points = 0;
  int position_bits = 0, normal_bits = 0;
};

// `count` chunks of the shape; chunk i holds data of kinds[i % kinds.size()].
std::vector<Chunk> MakeChunks(const Shape& shape, std::span<const Data> kinds, size_t count) {
  std::vector<Chunk> chunks;
  for (size_t i = 0; i < count; ++i) {
    chunks.push_back(MakeChunk(shape.points, shape.position_bits, shape.normal_bits,
                               kinds[i % kinds.size()], kWriterSeed + static_cast<unsigned>(i)));
  }
  return chunks;
}

void ExpectGroupIsAsOneByOne(const std::vector<Chunk>& chunks) {
  const DracoWriter writer;
  std::vector<QuantisedVertices> vertices;
  std::vector<Stream> alone;
  {
    const ChosenTarget baseline(Targets().back());
    for (const Chunk& chunk : chunks) {
      vertices.push_back(chunk.vertices());
      ASSERT_OK_AND_ASSIGN(const auto stream, testing::EncodePoints(writer, chunk.vertices(), 8.0));
      ASSERT_TRUE(HoldsIntegers(stream, chunk.vertices())) << "chunk " << alone.size();
      alone.push_back(stream);
    }
  }
  for (const int64_t target : Targets()) {
    const ChosenTarget chosen(target);
    std::vector<Stream> streams(chunks.size());
    ASSERT_OK(writer.Encode(vertices, 8.0, nullptr, streams));
    for (size_t i = 0; i < chunks.size(); ++i) {
      ASSERT_TRUE(streams[i] == alone[i])
          << draco_kernel::TargetName() << ", chunk " << i << " of " << chunks.size();
    }
  }
}

void ExpectGroupIsAsOneByOne(const Shape& shape, std::span<const Data> kinds, size_t count) {
  SCOPED_TRACE(fmt::format("{} chunks of {} points, {} and {} bits, {} kinds of data from {} on",
                           count, shape.points, shape.position_bits, shape.normal_bits,
                           kinds.size(), static_cast<int>(kinds.front())));
  ExpectGroupIsAsOneByOne(MakeChunks(shape, kinds, count));
}

// Every pair of bits with every kind of data. Each has another shape: 1 to 32 segments, and patches
// with about 2,000 points at most. This covers tables of 12 and 13 bits, and larger ones, which the
// lanes do not handle.
TEST(DracoLanes, IntegersSurviveAtBitsAndShapesTogether) {
  constexpr size_t kMostPoints = 2112;
  std::mt19937 random(kWriterSeed);
  std::set<int> segments_seen;
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : kAllNormalBits) {
      for (const Data& kind : kAllData) {
        const int segments = 1 + static_cast<int>(random() % 32);
        const auto patch = static_cast<size_t>(PointsPerPatch(segments));
        const size_t points = patch * (1 + random() % (kMostPoints / patch));
        SCOPED_TRACE(fmt::format("{} segments", segments));
        ExpectGroupIsAsOneByOne({points, position_bits, normal_bits}, {&kind, 1}, kFull);
        segments_seen.insert(segments);
      }
    }
  }
  EXPECT_EQ(segments_seen.size(), 32u);
}

// With 7 to 15 chunks, the other lanes repeat the last chunk.
TEST(DracoLanes, IntegersSurviveInGroupsThatAreNotFull) {
  for (size_t count = 1; count < kFull; ++count) {
    ExpectGroupIsAsOneByOne({467, 14, 10}, kAllData, count);
  }
}

// The last chunk of a scene may be smaller.
TEST(DracoLanes, IntegersSurviveWhereOneChunkHasAnotherSize) {
  for (const size_t count : {2u, 3u, 4u, 5u, 8u, 9u, 17u, 35u}) {
    std::vector<Chunk> chunks = MakeChunks({467, 12, 8}, kAllData, count - 1);
    chunks.push_back(MakeChunk(66, 12, 8, Data::kWalk, kWriterSeed));
    ExpectGroupIsAsOneByOne(chunks);
  }
}

// 4,096 patches of 1 segment, 32 patches of 32 segments, and the largest number of points of a chunk.
TEST(DracoLanes, IntegersSurviveInLargeChunks) {
  for (const Data& kind : kAllData) {
    ExpectGroupIsAsOneByOne({size_t{4096} * 3, 12, 8}, {&kind, 1}, kFull);
  }
  constexpr Data kWalk = Data::kWalk;
  ExpectGroupIsAsOneByOne({size_t{32} * 561, 11, 8}, {&kWalk, 1}, kFull);
  ExpectGroupIsAsOneByOne({65'535, 10, 7}, {&kWalk, 1}, kFull);
}

// Values that no view produces must not break the writer.
TEST(DracoWriter, ValuesOutOfRangeAreHarmless) {
  for (const auto& [position_bits, normal_bits] : {std::pair{12, 8}, {8, 6}, {16, 12}}) {
    Chunk chunk = MakeChunk(467, position_bits, normal_bits, Data::kRandom, kWriterSeed);
    for (uint8_t& byte : chunk.bytes) byte = 0xFF;
    for (size_t i = 0; i < chunk.bytes.size(); i += 3) chunk.bytes[i] = static_cast<uint8_t>(i);
    for (const int64_t target : Targets()) {
      const ChosenTarget chosen(target);
      ASSERT_OK_AND_ASSIGN(const auto stream,
                           testing::EncodePoints(DracoWriter(), chunk.vertices(), 8.0));
      EXPECT_OK(DecodeDracoChunkIntegers(stream));
    }
  }
}

TEST(DracoWriter, TakesNoMoreBytesThanLibdraco) {
  size_t ours = 0, theirs = 0;
  for (unsigned i = 0; i < 20; ++i) {
    const Chunk chunk = MakeChunk(2112, 12, 8, Data::kWalk, kWriterSeed + i);
    ASSERT_OK_AND_ASSIGN(const auto stream,
                         testing::EncodePoints(DracoWriter(), chunk.vertices(), 8.0));
    ASSERT_OK_AND_ASSIGN(const auto reference,
                         testing::EncodePoints(*MakeReferenceEncoder(), chunk.vertices(), 8.0));
    ours += stream.size();
    theirs += reference.size();
  }
  EXPECT_LE(ours, theirs);
}

TEST(DracoWriter, KeepsNoMoreMemoryThanItSays) {
  for (const auto& [points, position_bits, normal_bits] :
       {std::tuple{66u, 8, 6}, {2112u, 12, 8}, {2112u, 16, 12}, {17'952u, 14, 0}}) {
    const DracoWriter writer;
    EXPECT_EQ(writer.MemoryBytes(), 0u);
    for (const Data data : kAllData) {
      const std::vector<Chunk> chunks =
          MakeChunks({points, position_bits, normal_bits}, {&data, 1}, kFull);
      std::vector<QuantisedVertices> vertices;
      for (const Chunk& chunk : chunks) vertices.push_back(chunk.vertices());
      for (QuantisedVertices& some : vertices) some.is_sparse = true;
      std::vector<std::vector<uint8_t>> streams(chunks.size());
      ASSERT_OK(writer.Encode(vertices, 8.0, nullptr, streams));
    }

    EXPECT_LE(writer.MemoryBytes(), writer.WorkingBytes(points, position_bits, normal_bits));
    EXPECT_GT(2 * writer.MemoryBytes(), writer.WorkingBytes(points, position_bits, normal_bits));
  }
}

// A sparse chunk may use the scheme TAGGED. It takes it where that is shorter, and only there.
TEST(DracoWriter, SparseChunksTakeTheShorterScheme) {
  const DracoWriter writer;
  for (const size_t points : {1u, 3u, 96u, 700u, 2112u}) {
    for (const auto& [position_bits, normal_bits] : {std::pair(8, 0), {12, 8}, {16, 12}}) {
      for (const Data data : kAllData) {
        SCOPED_TRACE(fmt::format("{} points, {} bits, data {}", points, position_bits,
                                 static_cast<int>(data)));
        const Chunk chunk = MakeChunk(points, position_bits, normal_bits, data, kWriterSeed);
        QuantisedVertices vertices = chunk.vertices();
        ASSERT_OK_AND_ASSIGN(const auto raw, testing::EncodePoints(writer, vertices, 8.0));
        vertices.is_sparse = true;
        ASSERT_OK_AND_ASSIGN(const auto stream, testing::EncodePoints(writer, vertices, 8.0));
        EXPECT_TRUE(HoldsIntegers(stream, chunk.vertices()));
        EXPECT_LE(stream.size(), raw.size());
      }
    }
  }
  const Chunk few = MakeChunk(96, 12, 0, Data::kRandom, kWriterSeed);
  QuantisedVertices vertices = few.vertices();
  ASSERT_OK_AND_ASSIGN(const auto raw, testing::EncodePoints(writer, vertices, 8.0));
  vertices.is_sparse = true;
  ASSERT_OK_AND_ASSIGN(const auto stream, testing::EncodePoints(writer, vertices, 8.0));
  EXPECT_LT(stream.size(), 0.85 * static_cast<double>(raw.size()));  // 12 of 16 bits a value
}

// Random data does not compress, so it is stored plainly, with two bytes per value.
TEST(DracoWriter, RandomDataTakesNoMoreThanPlainSymbols) {
  const Chunk chunk = MakeChunk(2112, 16, 12, Data::kRandom, kWriterSeed);
  ASSERT_OK_AND_ASSIGN(const auto stream,
                       testing::EncodePoints(DracoWriter(), chunk.vertices(), 8.0));
  EXPECT_LE(stream.size(), 128 + 10 * chunk.points);
}

}  // namespace
}  // namespace latticed::testing
