// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What our writer promises beyond chunk_encoder_test.cc: the same bytes from every instruction set,
// and no more of them than libdraco.
#include "core/codec/draco_writer.h"

#include <cmath>
#include <set>
#include <string>

#include "core/codec/draco_kernel.h"
#include "core/codec/draco_symbols.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
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

TEST(DracoWriter, EveryInstructionSetWritesTheSameBytes) {
  std::vector<Chunk> chunks;  // 20 of each shape: a full group of lanes and one that is not
  for (const size_t points : {1u, 2u, 66u, 467u, 2112u}) {
    for (const auto& [position_bits, normal_bits] : {std::pair{12, 8}, {16, 12}, {8, 0}}) {
      for (unsigned i = 0; i < 20; ++i) {
        chunks.push_back(MakeChunk(points, position_bits, normal_bits,
                                   kAllData[i % std::size(kAllData)], kSeed + i));
      }
    }
  }
  std::vector<std::vector<uint8_t>> expected;
  std::set<std::string> names;
  for (const int64_t target : Targets()) {
    const ChosenTarget chosen(target);
    names.insert(draco_kernel::TargetName());
    const auto streams = EncodeAll(chunks);
    if (expected.empty()) expected = streams;
    for (size_t i = 0; i < chunks.size(); ++i) {
      ASSERT_TRUE(streams[i] == expected[i])
          << draco_kernel::TargetName() << ", chunk " << i << ", seed " << kSeed;
      const auto decoded = DecodeDracoChunkIntegers(streams[i]);
      ASSERT_OK(decoded);
      ASSERT_TRUE(decoded->positions == chunks[i].integers.positions);
      ASSERT_TRUE(decoded->normals == chunks[i].integers.normals);
    }
  }
  EXPECT_EQ(names.size(), Targets().size()) << "each target must have been dispatched to";
}

// All pairs of values and predictions of 6 bits, canonical or not, and random ones of 12.
TEST(DracoWriter, EveryInstructionSetFindsTheSameNormalSymbols) {
  std::mt19937 random(kSeed);
  const auto top6 = static_cast<uint32_t>(OctahedralMax(6));
  std::vector<uint8_t> s, t;
  for (uint32_t value = 0; value < (top6 + 1) * (top6 + 1); value += 7) {
    for (uint32_t previous = 0; previous < (top6 + 1) * (top6 + 1); previous += 5) {
      for (const uint32_t n : {previous, value}) {
        s.push_back(static_cast<uint8_t>(n % (top6 + 1)));
        t.push_back(static_cast<uint8_t>(n / (top6 + 1)));
      }
    }
  }
  std::vector<uint16_t> s_symbols(s.size()), t_symbols(s.size());
  for (const int64_t target : Targets()) {
    const ChosenTarget chosen(target);
    draco_kernel::NormalSymbols(s.data(), t.data(), s.size(), 6, s_symbols.data(),
                                t_symbols.data());
    for (size_t i = 1; i < s.size(); ++i) {
      const OctahedralNormal expected = NormalSymbols({s[i], t[i]}, {s[i - 1], t[i - 1]}, 6);
      ASSERT_EQ((OctahedralNormal{s_symbols[i], t_symbols[i]}), expected)
          << draco_kernel::TargetName() << " at " << i;
    }
  }
}

// Values that no view has cannot lead the writer astray.
TEST(DracoWriter, ValuesOutOfRangeAreHarmless) {
  for (const auto& [position_bits, normal_bits] : {std::pair{12, 8}, {8, 6}, {16, 12}}) {
    Chunk chunk = MakeChunk(467, position_bits, normal_bits, Data::kRandom, kSeed);
    for (uint8_t& byte : chunk.bytes) byte = 0xFF;
    for (size_t i = 0; i < chunk.bytes.size(); i += 3) chunk.bytes[i] = static_cast<uint8_t>(i);
    for (const int64_t target : Targets()) {
      const ChosenTarget chosen(target);
      const auto stream = DracoWriter().EncodePoints(chunk.vertices(), 8.0);
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
    const auto stream = MakeReferenceEncoder()->EncodePoints(chunk.vertices(), 8.0);
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
  const auto stream = DracoWriter().EncodePoints(chunk.vertices(), 8.0);
  ASSERT_OK(stream);
  EXPECT_LE(stream->size(), 128 + 10 * chunk.points);
}

}  // namespace
}  // namespace latticed::testing
