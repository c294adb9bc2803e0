// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/chunk_encoder.h"

#include <cstring>
#include <random>
#include <string>
#include <tuple>

#include "core/codec/draco_decode.h"
#include "core/codec/octahedral.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

enum class Data { kRandom, kConstant, kExtreme, kRamp };

struct Chunk {
  std::vector<uint8_t> bytes;  // QUANTISED layout
  DecodedIntegers integers;    // what the stream must hold
};

uint32_t Pick(Data data, size_t i, uint32_t top, std::mt19937& random) {
  switch (data) {
    case Data::kRandom:
      return std::uniform_int_distribution<uint32_t>(0, top)(random);
    case Data::kConstant:
      return top / 3;
    case Data::kExtreme:
      return i % 2 == 0 ? 0 : top;
    case Data::kRamp:
      return static_cast<uint32_t>(i) % (top + 1);
  }
  return 0;
}

Chunk MakeChunk(size_t points, int position_bits, int normal_bits, Data data) {
  std::mt19937 random(3);
  Chunk chunk;
  std::vector<uint16_t> position(3 * points);
  chunk.integers.positions.resize(3 * points);
  for (size_t i = 0; i < points; ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const uint32_t value = Pick(data, i + axis, (1u << position_bits) - 1, random);
      position[axis * points + i] = static_cast<uint16_t>(value);
      chunk.integers.positions[3 * i + axis] = value;
    }
  }
  chunk.bytes.resize(6 * points);
  std::memcpy(chunk.bytes.data(), position.data(), chunk.bytes.size());
  if (normal_bits == 0) return chunk;

  const size_t width = normal_bits <= 8 ? 1 : 2;
  chunk.bytes.resize((6 + 2 * width) * points);
  for (size_t i = 0; i < points; ++i) {
    const auto top = static_cast<uint32_t>(OctahedralMax(normal_bits));
    const OctahedralNormal n =
        CanonicaliseOctahedral({static_cast<int32_t>(Pick(data, i, top, random)),
                                static_cast<int32_t>(Pick(data, i + 1, top, random))},
                               normal_bits);
    std::memcpy(&chunk.bytes[6 * points + width * i], &n.s, width);
    std::memcpy(&chunk.bytes[(6 + width) * points + width * i], &n.t, width);
    chunk.integers.normals.push_back(static_cast<uint32_t>(n.s));
    chunk.integers.normals.push_back(static_cast<uint32_t>(n.t));
  }
  return chunk;
}

// One suite for every encoder.
using Encoder = std::string;
const auto kEncoders = ::testing::Values("reference", "latticed");

class EncodedIntegers
    : public ::testing::TestWithParam<std::tuple<Encoder, int, int, size_t, Data>> {};
INSTANTIATE_TEST_SUITE_P(All, EncodedIntegers,
                         ::testing::Combine(kEncoders, ::testing::Values(8, 11, 12, 14, 16),
                                            ::testing::Values(0, 6, 8, 10, 12),
                                            ::testing::Values(1, 2, 3, 66, 2112, 5000),
                                            ::testing::Values(Data::kRandom, Data::kConstant,
                                                              Data::kExtreme, Data::kRamp)));

TEST_P(EncodedIntegers, Survive) {
  const auto [encoder, position_bits, normal_bits, points, data] = GetParam();
  const Chunk chunk = MakeChunk(points, position_bits, normal_bits, data);
  const auto vertices =
      QuantisedVertices::FromBytes(chunk.bytes, points, position_bits, normal_bits);

  const auto stream = MakeChunkEncoder(encoder)->EncodePoints(vertices, 8.0);
  ASSERT_OK(stream);
  const auto decoded = DecodeDracoChunkIntegers(*stream);
  ASSERT_OK(decoded);

  EXPECT_EQ(decoded->positions, chunk.integers.positions);
  EXPECT_EQ(decoded->normals, chunk.integers.normals);
}

TEST(ChunkEncoder, IsCalledReference) { EXPECT_EQ(MakeReferenceEncoder()->name(), "reference"); }

TEST(ChunkEncoder, AnyRangeIsExact) {
  const Chunk chunk = MakeChunk(500, 14, 10, Data::kRandom);
  const auto vertices = QuantisedVertices::FromBytes(chunk.bytes, 500, 14, 10);
  // Far outside of what six decimals of text could carry.
  for (const double range : {0x1p-60, 0x1p-20, 1.0, 0x1p+40, 0x1p+100}) {
    const auto stream = MakeReferenceEncoder()->EncodePoints(vertices, range);
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

TEST(ChunkEncoder, MeshStreamsKeepPointsAndTriangles) {
  const Chunk chunk = MakeChunk(66, 12, 8, Data::kRandom);
  const auto vertices = QuantisedVertices::FromBytes(chunk.bytes, 66, 12, 8);
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i + 2 < 66; ++i) triangles.push_back({i + 2, i, i + 1});

  const auto stream = MakeReferenceEncoder()->EncodeMesh(vertices, 2.0, triangles);
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
      EXPECT_EQ(mesh->corner_vertices[3 * f + c], triangles[f][c]);
    }
  }
}

// Points and triangles so regular that libdraco's compressed connectivity takes under three bytes a
// face, which its own decoder refuses.
TEST(ChunkEncoder, MeshStreamsOfRegularChunksDecode) {
  for (const size_t points : {480u, 2112u}) {
    const Chunk chunk = MakeChunk(points, 12, 8, Data::kConstant);
    const auto vertices = QuantisedVertices::FromBytes(chunk.bytes, points, 12, 8);
    std::vector<std::array<uint32_t, 3>> triangles;
    for (uint32_t i = 0; i + 2 < points; ++i) {
      triangles.push_back({i, i + 1, i + 2});
      triangles.push_back({i, i + 2, i + 1});
    }

    const auto stream = MakeReferenceEncoder()->EncodeMesh(vertices, 2.0, triangles);
    ASSERT_OK(stream);
    const auto integers = DecodeDracoChunkIntegers(*stream);

    ASSERT_OK(integers);
    EXPECT_EQ(integers->positions, chunk.integers.positions);
    EXPECT_EQ(integers->normals, chunk.integers.normals);
  }
}

}  // namespace
}  // namespace latticed
