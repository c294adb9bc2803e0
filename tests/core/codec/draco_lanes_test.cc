// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Our writer as a server calls it: a group of chunks at a time, whose states the vector code keeps
// in lockstep. For each instruction set, stream by stream, the same bytes as from the chunk alone on
// a single state, which libdraco decodes to exactly the integers that went in.
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
#include "tests/support/instruction_sets.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr unsigned kSeed = 47;
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
                               kinds[i % kinds.size()], kSeed + static_cast<unsigned>(i)));
  }
  return chunks;
}

// Written alone; empty where libdraco does not decode the chunk's integers.
Stream Alone(const DracoWriter& writer, const Chunk& chunk) {
  const auto stream = testing::EncodePoints(writer, chunk.vertices(), 8.0);
  if (!stream.ok()) return {};
  const auto decoded = DecodeDracoChunkIntegers(*stream);
  const bool exact = decoded.ok() && decoded->positions == chunk.integers.positions &&
                     decoded->normals == chunk.integers.normals;
  return exact ? *stream : Stream{};
}

void ExpectGroupIsAsOneByOne(const std::vector<Chunk>& chunks) {
  const DracoWriter writer;
  std::vector<QuantisedVertices> vertices;
  std::vector<Stream> alone;
  {
    const ChosenTarget baseline(Targets().back());
    for (const Chunk& chunk : chunks) {
      vertices.push_back(chunk.vertices());
      alone.push_back(Alone(writer, chunk));
      ASSERT_FALSE(alone.back().empty()) << "chunk " << alone.size() - 1 << " alone";
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

// Every pair of bits with every kind of data, each at another shape: 1 to 32 segments, and as many
// patches as have about 2,000 points at most. Tables of 12 and 13 bits, and larger ones, which are
// not for the lanes.
TEST(DracoLanes, IntegersSurviveAtBitsAndShapesTogether) {
  constexpr size_t kMostPoints = 2112;
  std::mt19937 random(kSeed);
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

// From seven chunks on, fewer than sixteen: the other lanes repeat the last one's.
TEST(DracoLanes, IntegersSurviveInGroupsThatAreNotFull) {
  for (size_t count = 1; count < kFull; ++count) {
    ExpectGroupIsAsOneByOne({467, 14, 10}, kAllData, count);
  }
}

// 4,096 patches of one segment, 32 of 32, and as many points as a chunk may have.
TEST(DracoLanes, IntegersSurviveInLargeChunks) {
  for (const Data& kind : kAllData) {
    ExpectGroupIsAsOneByOne({size_t{4096} * 3, 12, 8}, {&kind, 1}, kFull);
  }
  constexpr Data kWalk = Data::kWalk;
  ExpectGroupIsAsOneByOne({size_t{32} * 561, 11, 8}, {&kWalk, 1}, kFull);
  ExpectGroupIsAsOneByOne({65'535, 10, 7}, {&kWalk, 1}, kFull);
}

}  // namespace
}  // namespace latticed::testing
