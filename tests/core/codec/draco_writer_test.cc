// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What our writer promises beyond chunk_encoder_test.cc and draco_lanes_test.cc: it survives any values,
// and takes no more bytes than libdraco.
#include "core/codec/draco_writer.h"

#include <cmath>
#include <string>

#include "core/codec/draco_kernel.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/instruction_sets.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr unsigned kSeed = 23;

std::vector<std::vector<uint8_t>> EncodeAll(std::span<const Chunk> chunks) {
  std::vector<QuantisedVertices> vertices;
  for (const Chunk& chunk : chunks) vertices.push_back(chunk.vertices());
  std::vector<std::vector<uint8_t>> streams(chunks.size());
  EXPECT_OK(DracoWriter().Encode(vertices, 8.0, nullptr, streams));
  return streams;
}

// Values that no view has cannot lead the writer astray.
TEST(DracoWriter, ValuesOutOfRangeAreHarmless) {
  for (const auto& [position_bits, normal_bits] : {std::pair{12, 8}, {8, 6}, {16, 12}}) {
    Chunk chunk = MakeChunk(467, position_bits, normal_bits, Data::kRandom, kSeed);
    for (uint8_t& byte : chunk.bytes) byte = 0xFF;
    for (size_t i = 0; i < chunk.bytes.size(); i += 3) chunk.bytes[i] = static_cast<uint8_t>(i);
    for (const int64_t target : Targets()) {
      const ChosenTarget chosen(target);
      const auto stream = testing::EncodePoints(DracoWriter(), chunk.vertices(), 8.0);
      ASSERT_OK(stream);
      EXPECT_OK(DecodeDracoChunkIntegers(*stream));
    }
  }
}

// Patches of a rippled surface, 10 segments: in the pattern's serpentine order or row by row.
Chunk RippledChunk(double at, bool serpentine) {
  constexpr int kSegments = 10;
  constexpr size_t kPatches = 32;
  const auto& pattern = TessellationPattern::Get(kSegments);
  const size_t patch_points = pattern.points.size(), points = kPatches * patch_points;
  Chunk chunk{.points = points, .position_bits = 12, .normal_bits = 8};
  std::vector<uint16_t> planes(3 * points);
  std::vector<uint8_t> normals(2 * points);
  for (size_t i = 0; i < points; ++i) {
    const size_t patch = i / patch_points;
    auto [i0, i1, i2] = pattern.points[i % patch_points];
    if (!serpentine && i2 % 2 != 0) std::swap(i0, i1);
    const double u = at + 0.04 * (static_cast<double>(patch % 8) + i1 / double{kSegments});
    const double v = at + 0.04 * (static_cast<double>(patch / 8) + i2 / double{kSegments});
    const Vec3d p{u, v, 0.1 * std::sin(9 * u) * std::cos(7 * v)};
    const Vec3f n{static_cast<float>(-0.9 * std::cos(9 * u) * std::cos(7 * v)),
                  static_cast<float>(0.7 * std::sin(9 * u) * std::sin(7 * v)), 1.0f};
    for (size_t axis = 0; axis < 3; ++axis) {
      planes[axis * points + i] =
          static_cast<uint16_t>(std::lround(1000 + 1500 * p[static_cast<int>(axis)]));
    }
    const OctahedralNormal octahedral = QuantiseNormal(n, 8);
    normals[i] = static_cast<uint8_t>(octahedral.s);
    normals[points + i] = static_cast<uint8_t>(octahedral.t);
  }
  chunk.bytes.resize(8 * points);
  std::memcpy(chunk.bytes.data(), planes.data(), 6 * points);
  std::memcpy(chunk.bytes.data() + 6 * points, normals.data(), 2 * points);
  return chunk;
}

TEST(DracoWriter, TakesNoMoreBytesThanLibdracoAndTenPercentLessThanRowByRow) {
  std::vector<Chunk> serpentine, rows;
  for (int i = 0; i < 20; ++i) {
    serpentine.push_back(RippledChunk(0.04 * i, true));
    rows.push_back(RippledChunk(0.04 * i, false));
  }
  size_t ours = 0, ours_by_row = 0, theirs = 0;
  for (const auto& stream : EncodeAll(serpentine)) ours += stream.size();
  for (const auto& stream : EncodeAll(rows)) ours_by_row += stream.size();
  for (const Chunk& chunk : serpentine) {
    const auto stream = testing::EncodePoints(*MakeReferenceEncoder(), chunk.vertices(), 8.0);
    ASSERT_OK(stream);
    theirs += stream->size();
  }
  EXPECT_LE(ours, theirs);
  EXPECT_LE(static_cast<double>(ours), 0.9 * static_cast<double>(ours_by_row));
}

TEST(DracoWriter, KeepsNoMoreMemoryThanItSays) {
  for (const auto& [points, position_bits, normal_bits] :
       {std::tuple{66u, 8, 6}, {2112u, 12, 8}, {2112u, 16, 12}, {17'952u, 14, 0}}) {
    const DracoWriter writer;
    EXPECT_EQ(writer.MemoryBytes(), 0u);
    for (const Data data : kAllData) {
      std::vector<Chunk> chunks;
      for (unsigned i = 0; i < 16; ++i) {
        chunks.push_back(MakeChunk(points, position_bits, normal_bits, data, kSeed + i));
      }
      std::vector<QuantisedVertices> vertices;
      for (const Chunk& chunk : chunks) vertices.push_back(chunk.vertices());
      std::vector<std::vector<uint8_t>> streams(chunks.size());
      ASSERT_OK(writer.Encode(vertices, 8.0, nullptr, streams));
    }

    EXPECT_LE(writer.MemoryBytes(), writer.WorkingBytes(points, position_bits, normal_bits));
    EXPECT_GT(2 * writer.MemoryBytes(), writer.WorkingBytes(points, position_bits, normal_bits));
  }
}

// Nothing to gain from: stored plainly, two bytes a value.
TEST(DracoWriter, RandomDataTakesNoMoreThanPlainSymbols) {
  const Chunk chunk = MakeChunk(2112, 16, 12, Data::kRandom, kSeed);
  const auto stream = testing::EncodePoints(DracoWriter(), chunk.vertices(), 8.0);
  ASSERT_OK(stream);
  EXPECT_LE(stream->size(), 128 + 10 * chunk.points);
}

}  // namespace
}  // namespace latticed::testing
