// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_decode.h"

#include <random>
#include <string>

#include "core/base/error.h"
#include "core/codec/draco_announcement.h"
#include "core/mesh/triangle_mesh.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

// A grid of 11 x 11 points on a paraboloid, far from the origin, with normals and uvs.
TriangleMesh MakeGrid() {
  TriangleMesh mesh;
  constexpr uint32_t kSide = 11;
  for (uint32_t j = 0; j < kSide; ++j) {
    for (uint32_t i = 0; i < kSide; ++i) {
      const double x = 0.1 * i, y = 0.1 * j;
      mesh.positions.push_back({100 + x, -50 + y, x * x + y * y});
      const Vec3d n{-2 * x, -2 * y, 1};
      mesh.normals.push_back(ToFloat(n / Norm(n)));
      mesh.uvs.push_back({static_cast<float>(x), static_cast<float>(y)});
    }
  }
  for (uint32_t j = 0; j + 1 < kSide; ++j) {
    for (uint32_t i = 0; i + 1 < kSide; ++i) {
      const uint32_t p = i + kSide * j;
      mesh.triangles.push_back({p, p + 1, p + kSide});
      mesh.triangles.push_back({p + 1, p + kSide + 1, p + kSide});
    }
  }
  return mesh;
}

std::span<const uint8_t> Bytes(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

TEST(DracoMesh, RoundTrip) {
  const TriangleMesh mesh = MakeGrid();

  ASSERT_OK_AND_ASSIGN(const auto stream, WriteDracoMesh(Welded(mesh)));
  ASSERT_OK_AND_ASSIGN(const auto back, ReadDracoMesh(stream));

  ASSERT_EQ(back.positions.size(), mesh.positions.size());
  ASSERT_EQ(back.face_count(), mesh.triangles.size());
  ASSERT_TRUE(back.has_normals());
  ASSERT_TRUE(back.has_uvs());
  // Half a step of the longest edge (z: 2), plus float rounding at 100.
  const double tolerance = 0.5 * 2.0 / 65535 + 100 * 0x1p-23;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(back.positions[i][axis], mesh.positions[i][axis], tolerance);
    }
    EXPECT_NEAR(back.uvs[i].x, mesh.uvs[i].x, 1.0 / 4095);
    EXPECT_GT(Dot(ToDouble(back.normals[i]), ToDouble(mesh.normals[i])), 1 - 1e-5);
  }
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(back.corner_vertices[3 * f + c], mesh.triangles[f][c]);
      EXPECT_EQ(back.corner_uvs[3 * f + c], mesh.triangles[f][c]);
    }
  }
}

TEST(DracoMesh, UvsStayFineUnderCoarseNormalsAndPositions) {
  const TriangleMesh mesh = MakeGrid();
  const struct {
    int position_bits, normal_bits;
    double uv_step;
  } cases[] = {{16, 6, 1.0 / 65535}, {8, 6, 1.0 / 4095}};
  for (const auto& bits : cases) {
    ASSERT_OK_AND_ASSIGN(const auto stream,
                         WriteDracoMesh(Welded(mesh), bits.position_bits, bits.normal_bits));
    ASSERT_OK_AND_ASSIGN(const auto back, ReadDracoMesh(stream));
    for (size_t i = 0; i < mesh.uvs.size(); ++i) {
      EXPECT_NEAR(back.uvs[i].x, mesh.uvs[i].x, 0.5 * bits.uv_step + 1e-6);
      EXPECT_NEAR(back.uvs[i].y, mesh.uvs[i].y, 0.5 * bits.uv_step + 1e-6);
    }
  }
}

TEST(DracoMesh, BarePositionsAndAFlatMesh) {
  TriangleMesh mesh;
  mesh.positions = {{5, 5, 5}, {5, 5, 5}, {5, 5, 5}};
  mesh.triangles = {{0, 1, 2}};

  ASSERT_OK_AND_ASSIGN(const auto stream, WriteDracoMesh(Welded(mesh), 11, 8));
  ASSERT_OK_AND_ASSIGN(const auto back, ReadDracoMesh(stream));

  EXPECT_FALSE(back.has_normals());
  EXPECT_FALSE(back.has_uvs());
  for (const Vec3d p : back.positions) EXPECT_EQ(p, (Vec3d{5, 5, 5}));
}

TEST(DracoMesh, EveryTruncationIsRefused) {
  ASSERT_OK_AND_ASSIGN(const auto stream, WriteDracoMesh(Welded(MakeGrid())));
  for (size_t size = 0; size < stream.size(); ++size) {
    // A copy, so that a sanitizer sees reads past the end.
    const std::string cut = stream.substr(0, size);
    const auto mesh = ReadDracoMesh(cut);
    ASSERT_THAT(mesh, StatusIs(absl::StatusCode::kInvalidArgument)) << size << " bytes";
    EXPECT_EQ(error::DetailsOf(mesh.status()).reason, "MALFORMED_FILE");
  }
}

TEST(DracoMesh, CorruptBytesNeverCrash) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  ASSERT_OK_AND_ASSIGN(const auto stream, WriteDracoMesh(Welded(MakeGrid())));
  for (int round = 0; round < 2000; ++round) {
    std::string corrupt = stream;
    for (int k = 0; k < 3; ++k) corrupt[random() % corrupt.size()] = static_cast<char>(random());
    const auto mesh = ReadDracoMesh(corrupt);
    // Changed payload bits may still decode to a mesh, which must then be valid.
    if (mesh.ok()) {
      EXPECT_OK(Validate(*mesh)) << "seed " << kSeed << " round " << round;
    }
    (void)DecodeDracoChunk(Bytes(corrupt));
    (void)DecodeDracoChunkIntegers(Bytes(corrupt));
  }
}

TEST(DracoMesh, OtherFilesAreRefused) {
  EXPECT_THAT(ReadDracoMesh(""), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(ReadDracoMesh("ply\nformat ascii 1.0\n"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("DRACO")));
}

// The header of a mesh or point cloud of version 2.2 or 2.3, then `rest`.
std::string Header(char minor, char geometry, char method, const std::string& rest) {
  return std::string("DRACO") + '\2' + minor + geometry + method + std::string(2, '\0') + rest;
}

// Found by fuzzing: 43 bytes of version 2.1 with an attribute that announces 460 million points.
TEST(DracoAnnouncement, AChunkThatIsAKdTreeIsRefusedBeforeItIsDecoded) {
  std::string cloud("DRACO\x02\x01\0\x01\0\0\0\x02\0\0\x02\x02\x02\x02\x02", 20);
  cloud += std::string(17, '\x01') + "\xff\xa4\xfe\xf8\x01\x01";
  EXPECT_THAT(DecodeDracoChunk(Bytes(cloud)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("k-d tree")));
}

TEST(DracoAnnouncement, HugeCountsAreRefusedBeforeAllocation) {
  const std::string two_thousand_million("\xff\xff\xff\x7f", 4);
  const std::string cloud = Header(3, 0, 0, two_thousand_million + std::string(20, '\0'));
  const std::string varint("\xff\xff\xff\xff\x07", 5);
  const std::string sequential = Header(2, 1, 0, varint + varint + std::string(20, '\0'));
  const std::string edgebreaker =
      Header(2, 1, 1, std::string(1, '\0') + varint + varint + std::string(20, '\0'));

  EXPECT_THAT(DecodeDracoChunk(Bytes(cloud)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("2147483647 points")));
  EXPECT_THAT(ReadDracoMesh(sequential),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("2147483647 faces")));
  EXPECT_THAT(ReadDracoMesh(edgebreaker),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("2147483647 faces")));
  EXPECT_THAT(ReadDracoMesh(cloud),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("point cloud")));
}

TEST(DracoAnnouncement, ReadsCounts) {
  ASSERT_OK_AND_ASSIGN(const auto stream, WriteDracoMesh(Welded(MakeGrid())));
  ASSERT_OK_AND_ASSIGN(const auto announcement, ReadDracoAnnouncement(Bytes(stream)));
  EXPECT_TRUE(announcement.is_mesh);
  EXPECT_EQ(announcement.points, 121u);
  EXPECT_EQ(announcement.faces, 200u);
  EXPECT_OK(CheckDracoSize(announcement, stream.size()));
}

}  // namespace
}  // namespace latticed
