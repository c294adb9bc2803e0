// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/vertex_decoder.h"

#include <array>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "client/cpp/library/surface.h"
#include "core/codec/draco_geometry.h"
#include "core/codec/octahedral.h"
#include "tests/client/surface_events.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using latticed::testing::StatusIs;
using testing::ApplyUpdate;
using testing::DracoChunk;
using testing::QuantisedChunk;
using testing::RawChunk;

TEST(VertexDecoder, WritesVertices) {
  const std::array<uint32_t, 2> chunks{1, 0};
  VertexDecoder decoder;
  for (const auto& [encoding, first, second] :
       {std::tuple{v1::ENCODING_RAW, RawChunk(10), RawChunk(20)},
        {v1::ENCODING_QUANTISED, QuantisedChunk(10), QuantisedChunk(20)},
        {v1::ENCODING_DRACO_POINTS, DracoChunk(10, "latticed"), DracoChunk(20)}}) {
    SCOPED_TRACE(encoding);
    Surface surface;
    ApplyUpdate(surface, encoding, first, second);
    ASSERT_OK_AND_ASSIGN(const uint64_t count, surface.PointCount(chunks));
    ASSERT_EQ(count, 6u);
    ASSERT_OK_AND_ASSIGN(const DecodedPoints points, surface.Decode(chunks));
    std::vector<WorldVertex> world(count);
    ASSERT_OK(surface.Decode(chunks, &decoder, world));
    for (size_t i = 0; i < count; ++i) {
      EXPECT_EQ(world[i], (WorldVertex{ToFloat(points.positions[i]), points.normals[i]}));
    }
    std::vector<GridVertex> grid(count);
    const absl::Status status = surface.Decode(chunks, &decoder, grid);
    if (encoding == v1::ENCODING_RAW) {
      EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument));
      continue;
    }
    ASSERT_OK(status);
    const OctahedralNormal n = QuantiseNormal({0, 0, 1}, 8);
    for (uint16_t i = 0; i < 6; ++i) {
      const auto x = static_cast<uint16_t>(i < 3 ? 20 + i : 7 + i);
      const auto y = static_cast<uint16_t>(2 * x), z = static_cast<uint16_t>(3 * x);
      EXPECT_EQ(grid[i],
                (GridVertex{x, y, z, 0, static_cast<uint16_t>(n.s), static_cast<uint16_t>(n.t)}));
    }
  }
}

TEST(VertexDecoder, RefusesMemoryOfAnotherSize) {
  const std::array<uint32_t, 1> chunk{0}, none{2};
  const auto invalid = StatusIs(absl::StatusCode::kInvalidArgument);
  VertexDecoder decoder;
  std::vector<GridVertex> grid(4);
  std::vector<WorldVertex> world(2);
  Surface surface;
  EXPECT_THAT(surface.PointCount(chunk), StatusIs(absl::StatusCode::kFailedPrecondition));
  ApplyUpdate(surface, v1::ENCODING_QUANTISED, QuantisedChunk(10), QuantisedChunk(20));

  EXPECT_THAT(surface.PointCount(none), invalid);
  EXPECT_THAT(surface.Decode(chunk, &decoder, grid), invalid);
  EXPECT_THAT(surface.Decode(chunk, &decoder, world), invalid);
  EXPECT_OK(surface.Decode(chunk, &decoder, std::span(grid).first(3)));
}

TEST(VertexDecoder, NumbersOfMoreThan16BitsAreDataLoss) {
  DracoGeometry geometry{.point_count = 3, .position_bits = 17, .normal_bits = 8};
  geometry.grid_positions.assign(9, 70'000.0f);
  geometry.normals.assign(9, 1.0f);
  ASSERT_OK_AND_ASSIGN(const auto stream, EncodeDraco(geometry, std::nullopt));
  Surface surface;
  ApplyUpdate(surface, v1::ENCODING_DRACO_POINTS, {stream.begin(), stream.end()}, DracoChunk(20));
  EXPECT_THAT(surface.Decode(), StatusIs(absl::StatusCode::kDataLoss));
}

}  // namespace
}  // namespace latticed::client
