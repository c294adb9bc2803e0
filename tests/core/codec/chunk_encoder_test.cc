// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One suite for every encoder: libdraco must decode exactly the integers that went in.
#include "core/codec/chunk_encoder.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr unsigned kSeed = 3;

class ChunkEncoderTest : public ::testing::TestWithParam<const char*> {
 protected:
  void ExpectIntegersSurvive(const Chunk& chunk) {
    SCOPED_TRACE(fmt::format("{} points, {} and {} bits, seed {}", chunk.points,
                             chunk.position_bits, chunk.normal_bits, kSeed));
    const auto stream = testing::EncodePoints(*encoder_, chunk.vertices(), 8.0);
    ASSERT_OK(stream);
    const auto decoded = DecodeDracoChunkIntegers(*stream);
    ASSERT_OK(decoded);
    ASSERT_TRUE(decoded->positions == chunk.integers.positions);
    ASSERT_TRUE(decoded->normals == chunk.integers.normals);
  }

  const std::unique_ptr<ChunkEncoder> encoder_ = MakeChunkEncoder(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Encoders, ChunkEncoderTest, ::testing::Values("reference", "latticed"),
                         [](const auto& encoder) { return std::string(encoder.param); });

TEST_P(ChunkEncoderTest, HasItsName) {
  EXPECT_EQ(encoder_->name(), GetParam());
  EXPECT_EQ(MakeChunkEncoder("zip"), nullptr);
}

TEST_P(ChunkEncoderTest, IntegersSurviveAtAllBits) {
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : {0, 6, 7, 8, 9, 10, 11, 12}) {
      for (const Data data : kAllData) {
        ExpectIntegersSurvive(MakeChunk(1000, position_bits, normal_bits, data, kSeed));
      }
    }
  }
}

TEST_P(ChunkEncoderTest, IntegersSurviveAtAllSizes) {
  for (const size_t points :
       {1u, 2u, 3u, 4u, 5u, 31u, 32u, 33u, 64u, 66u, 2112u, 12'289u, 65'535u}) {
    for (const Data data : kAllData) {
      ExpectIntegersSurvive(MakeChunk(points, 12, 8, data, kSeed));
      if (points < 5000) ExpectIntegersSurvive(MakeChunk(points, 16, 12, data, kSeed));
    }
  }
}

// Every pair of bits with every kind of data, each in a chunk of another shape: at 1 to 32 segments,
// of as many patches as have 12,288 points at most, which are 4,096 of one segment.
TEST_P(ChunkEncoderTest, IntegersSurviveAtBitsAndShapesTogether) {
  std::mt19937 random(kSeed);
  std::set<int> segments_seen;
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : {0, 6, 7, 8, 9, 10, 11, 12}) {
      for (const Data data : kAllData) {
        const int segments = 1 + static_cast<int>(random() % 32);
        const auto patch = static_cast<size_t>(PointsPerPatch(segments));
        const size_t patches = 1 + random() % std::min<size_t>(4096, 12'288 / patch);
        SCOPED_TRACE(fmt::format("{} patches of {} segments", patches, segments));
        ExpectIntegersSurvive(MakeChunk(patches * patch, position_bits, normal_bits, data,
                                        static_cast<unsigned>(random())));
        segments_seen.insert(segments);
      }
    }
  }
  EXPECT_EQ(segments_seen.size(), 32u);
}

TEST_P(ChunkEncoderTest, BatchesAreAsOneByOne) {
  for (const size_t count : {2u, 3u, 4u, 5u, 8u, 9u, 17u, 35u}) {
    std::vector<Chunk> chunks;
    std::vector<QuantisedVertices> vertices;
    for (size_t i = 0; i < count; ++i) {  // of different data, the last of another size
      const size_t points = i + 1 < count ? 467 : 66;
      chunks.push_back(
          MakeChunk(points, 12, 8, kAllData[i % std::size(kAllData)], static_cast<unsigned>(i)));
    }
    for (const Chunk& chunk : chunks) vertices.push_back(chunk.vertices());
    std::vector<std::vector<uint8_t>> streams(count);
    ASSERT_OK(encoder_->Encode(vertices, 8.0, nullptr, streams));

    for (size_t i = 0; i < count; ++i) {
      const auto alone = testing::EncodePoints(*encoder_, vertices[i], 8.0);
      ASSERT_OK(alone);
      EXPECT_TRUE(streams[i] == *alone) << "chunk " << i << " of " << count;
    }
  }
}

TEST_P(ChunkEncoderTest, AnyRangeIsExact) {
  const Chunk chunk = MakeChunk(500, 14, 10, Data::kRandom, kSeed);
  // Far outside of what six decimals of text could carry.
  for (const double range : {0x1p-60, 0x1p-20, 1.0, 0x1p+40, 0x1p+100}) {
    const auto stream = testing::EncodePoints(*encoder_, chunk.vertices(), range);
    ASSERT_OK(stream);
    const auto decoded = DecodeDracoChunk(*stream);
    ASSERT_OK(decoded);

    ASSERT_EQ(decoded->positions.size(), 1500u);
    const float step = static_cast<float>(range) / 16383.0f;
    for (size_t i = 0; i < 1500; ++i) {
      ASSERT_EQ(decoded->positions[i], static_cast<float>(chunk.integers.positions[i]) * step)
          << "range " << range << " value " << i;
    }
    for (size_t i = 0; i < 500; ++i) {
      const Vec3f n = DequantiseNormal({static_cast<int32_t>(chunk.integers.normals[2 * i]),
                                        static_cast<int32_t>(chunk.integers.normals[2 * i + 1])},
                                       10);
      ASSERT_EQ((Vec3f{decoded->normals[3 * i], decoded->normals[3 * i + 1],
                       decoded->normals[3 * i + 2]}),
                n);
    }
  }
}

using Triangles = std::vector<std::array<uint32_t, 3>>;

void ExpectMeshDecodes(const ChunkEncoder& encoder, const Chunk& chunk,
                       const Triangles& triangles) {
  const auto stream = testing::EncodeMesh(encoder, chunk.vertices(), 2.0, triangles);
  ASSERT_OK(stream);
  const auto integers = DecodeDracoChunkIntegers(*stream);
  ASSERT_OK(integers);
  const auto mesh = ReadDracoMesh({reinterpret_cast<const char*>(stream->data()), stream->size()});
  ASSERT_OK(mesh);

  EXPECT_EQ(integers->positions, chunk.integers.positions);
  EXPECT_EQ(integers->normals, chunk.integers.normals);
  ASSERT_EQ(mesh->face_count(), triangles.size());
  for (size_t f = 0; f < triangles.size(); ++f) {
    for (size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(mesh->corner_vertices[3 * f + c], triangles[f][c]);
    }
  }
}

// The triangles of whole chunks at all segments; two of segments 32 fill 16-bit indices.
TEST_P(ChunkEncoderTest, MeshStreamsOfPatchesDecode) {
  for (const int segments : {1, 2, 3, 10, 31, 32}) {
    const TessellationPattern& pattern = TessellationPattern::Get(segments);
    Triangles triangles;
    for (uint32_t patch = 0; patch < 32; ++patch) {
      const auto base = patch * static_cast<uint32_t>(pattern.points.size());
      for (const auto& t : pattern.triangles) {
        triangles.push_back({base + t[0], base + t[1], base + t[2]});
      }
    }
    const size_t points = 32 * pattern.points.size();
    ExpectMeshDecodes(*encoder_, MakeChunk(points, 12, 8, Data::kWalk, kSeed), triangles);
  }
}

TEST_P(ChunkEncoderTest, MeshStreamsWithoutPatternDecode) {
  constexpr size_t kPoints = 65'535;
  std::mt19937 random(kSeed);
  Triangles triangles(kPoints / 3);  // libdraco decodes no fewer
  for (auto& triangle : triangles) {
    for (uint32_t& index : triangle) index = static_cast<uint32_t>(random()) % kPoints;
  }
  ExpectMeshDecodes(*encoder_, MakeChunk(kPoints, 12, 8, Data::kWalk, kSeed), triangles);
}

// Points and triangles so regular that a compressed connectivity takes under three bytes a face,
// which libdraco's decoder refuses.
TEST_P(ChunkEncoderTest, MeshStreamsOfRegularChunksDecode) {
  for (const size_t points : {480u, 2112u}) {
    Triangles triangles;
    for (uint32_t i = 0; i + 2 < points; ++i) {
      triangles.push_back({i, i + 1, i + 2});
      triangles.push_back({i, i + 2, i + 1});
    }
    const Chunk chunk = MakeChunk(points, 12, 8, Data::kConstant, kSeed);
    const auto stream = testing::EncodeMesh(*encoder_, chunk.vertices(), 2.0, triangles);
    ASSERT_OK(stream);
    const auto integers = DecodeDracoChunkIntegers(*stream);

    ASSERT_OK(integers);
    EXPECT_EQ(integers->positions, chunk.integers.positions);
    EXPECT_EQ(integers->normals, chunk.integers.normals);
  }
}

}  // namespace
}  // namespace latticed::testing
