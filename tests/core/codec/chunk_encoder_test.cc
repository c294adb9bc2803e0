// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One suite for every encoder: libdraco must decode exactly the encoded integers.
#include "core/codec/chunk_encoder.h"

#include <array>
#include <string>

#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/holds_integers.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr unsigned kEncoderSeed = 3;

class ChunkEncoderTest : public ::testing::TestWithParam<const char*> {
 protected:
  void ExpectIntegersSurvive(const Chunk& chunk) {
    SCOPED_TRACE(fmt::format("{} points, {} and {} bits, seed {}", chunk.points,
                             chunk.position_bits, chunk.normal_bits, kEncoderSeed));
    ASSERT_OK_AND_ASSIGN(const auto stream,
                         testing::EncodePoints(*encoder_, chunk.vertices(), 8.0));
    ASSERT_TRUE(HoldsIntegers(stream, chunk.vertices()));
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
        ExpectIntegersSurvive(MakeChunk(1000, position_bits, normal_bits, data, kEncoderSeed));
      }
    }
  }
}

TEST_P(ChunkEncoderTest, IntegersSurviveAtAllSizes) {
  for (const size_t points :
       {1u, 2u, 3u, 4u, 5u, 31u, 32u, 33u, 64u, 66u, 2112u, 12'289u, 65'535u}) {
    for (const Data data : kAllData) {
      ExpectIntegersSurvive(MakeChunk(points, 12, 8, data, kEncoderSeed));
      if (points < 5000) ExpectIntegersSurvive(MakeChunk(points, 16, 12, data, kEncoderSeed));
    }
  }
}

TEST_P(ChunkEncoderTest, AnyRangeIsExact) {
  const Chunk chunk = MakeChunk(500, 14, 10, Data::kRandom, kEncoderSeed);
  // Far outside the range that six decimals of text can hold.
  for (const double range : {0x1p-60, 0x1p-20, 1.0, 0x1p+40, 0x1p+100}) {
    ASSERT_OK_AND_ASSIGN(const auto stream,
                         testing::EncodePoints(*encoder_, chunk.vertices(), range));
    ASSERT_OK_AND_ASSIGN(const auto decoded, DecodeDracoChunk(stream));

    ASSERT_EQ(decoded.positions.size(), 1500u);
    const float step = static_cast<float>(range) / 16383.0f;
    for (size_t i = 0; i < 1500; ++i) {
      ASSERT_EQ(decoded.positions[i], static_cast<float>(chunk.integers.positions[i]) * step)
          << "range " << range << " value " << i;
    }
    for (size_t i = 0; i < 500; ++i) {
      const Vec3f n = DequantiseNormal({static_cast<int32_t>(chunk.integers.normals[2 * i]),
                                        static_cast<int32_t>(chunk.integers.normals[2 * i + 1])},
                                       10);
      ASSERT_EQ(
          (Vec3f{decoded.normals[3 * i], decoded.normals[3 * i + 1], decoded.normals[3 * i + 2]}),
          n);
    }
  }
}

using Triangles = std::vector<std::array<uint32_t, 3>>;

void ExpectMeshDecodes(const ChunkEncoder& encoder, const Chunk& chunk,
                       const Triangles& triangles) {
  ASSERT_OK_AND_ASSIGN(const auto stream,
                       testing::EncodeMesh(encoder, chunk.vertices(), 2.0, triangles));
  EXPECT_TRUE(HoldsIntegers(stream, chunk.vertices()));
  ASSERT_OK_AND_ASSIGN(const auto mesh, ReadDracoMesh({reinterpret_cast<const char*>(stream.data()),
                                                       stream.size()}));

  ASSERT_EQ(mesh.face_count(), triangles.size());
  for (size_t f = 0; f < triangles.size(); ++f) {
    for (size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(mesh.corner_vertices[3 * f + c], triangles[f][c]);
    }
  }
}

// The triangles of whole chunks of 32 patches, up to the largest number of segments.
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
    ExpectMeshDecodes(*encoder_, MakeChunk(points, 12, 8, Data::kWalk, kEncoderSeed), triangles);
  }
}

TEST_P(ChunkEncoderTest, MeshStreamsWithoutPatternDecode) {
  constexpr size_t kPoints = 65'535;
  std::mt19937 random(kEncoderSeed);
  Triangles triangles(kPoints / 3);  // libdraco decodes no fewer
  for (auto& triangle : triangles) {
    for (uint32_t& index : triangle) index = static_cast<uint32_t>(random()) % kPoints;
  }
  ExpectMeshDecodes(*encoder_, MakeChunk(kPoints, 12, 8, Data::kWalk, kEncoderSeed), triangles);
}

// Points and triangles are so regular that compressed connectivity would take less than three bytes
// per face, which libdraco's decoder refuses.
TEST_P(ChunkEncoderTest, MeshStreamsOfRegularChunksDecode) {
  for (const size_t points : {480u, 2112u}) {
    Triangles triangles;
    for (uint32_t i = 0; i + 2 < points; ++i) {
      triangles.push_back({i, i + 1, i + 2});
      triangles.push_back({i, i + 2, i + 1});
    }
    const Chunk chunk = MakeChunk(points, 12, 8, Data::kConstant, kEncoderSeed);
    ASSERT_OK_AND_ASSIGN(const auto stream,
                         testing::EncodeMesh(*encoder_, chunk.vertices(), 2.0, triangles));
    EXPECT_TRUE(HoldsIntegers(stream, chunk.vertices()));
  }
}

}  // namespace
}  // namespace latticed::testing
