// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/mesh_io.h"

#include "core/mesh/sample_meshes.h"
#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using ::latticed::testing::IsMalformed;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr char kTriangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(ObjReaderTest, FacesOfAnySize) {
  ASSERT_OK_AND_ASSIGN(
      const auto mesh,
      ReadObj("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 .5 0\nv 0 1 0\nf 1 2 3 4 5\nf 1 2 3 4\nf 1 2 3\n"));
  EXPECT_THAT(mesh.face_offsets, ElementsAre(0, 5, 9, 12));
  EXPECT_EQ(mesh.positions[3], (Vec3d{1, 0.5, 0}));
}

TEST(ObjReaderTest, EveryFormOfCorner) {
  ASSERT_OK_AND_ASSIGN(const auto mesh,
                       ReadObj(std::string(kTriangle) +
                               "vt 0 0\nvt 1 0 0.5\nvt 0.5\nvn 0 0 2\nvn 1 0 0\n"
                               "f 1 2 3\nf 1/1 2/2 3/3\nf 1//1 2//2 3//1\nf 1/1/1 2/2/2 3/3/1\n"));
  constexpr uint32_t kNone = PolygonMesh::kNoAttribute;
  EXPECT_THAT(mesh.corner_uvs,
              ElementsAre(kNone, kNone, kNone, 0, 1, 2, kNone, kNone, kNone, 0, 1, 2));
  EXPECT_THAT(mesh.corner_normals,
              ElementsAre(kNone, kNone, kNone, kNone, kNone, kNone, 0, 1, 0, 0, 1, 0));
  EXPECT_EQ(mesh.uvs[2], (Vec2f{0.5f, 0}));
  EXPECT_EQ(mesh.normals[0], (Vec3f{0, 0, 2}));  // kept as written
}

TEST(ObjReaderTest, AttributesThatNoCornerUsesAreDropped) {
  ASSERT_OK_AND_ASSIGN(const auto mesh,
                       ReadObj(std::string(kTriangle) + "vn 0 0 1\nvt 0 0\nf 1 2 3\n"));
  EXPECT_FALSE(mesh.has_normals());
  EXPECT_FALSE(mesh.has_uvs());
  EXPECT_THAT(mesh.corner_normals, IsEmpty());
}

TEST(ObjReaderTest, NegativeAndForwardIndices) {
  ASSERT_OK_AND_ASSIGN(const auto mesh,
                       ReadObj("f 3 2 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 9 9\n"));
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(2, 1, 0, 0, 1, 2));
}

TEST(ObjReaderTest, LineEndsContinuationsCommentsAndBlanks) {
  ASSERT_OK_AND_ASSIGN(const auto mesh,
                       ReadObj("\xEF\xBB\xBF# comment\r\nv 0 0 0 # origin\r\n\tv\t1  0 0\r\nv 0 "
                               "\\\r\n 1 0\r\n\r\nmtllib "
                               "x.mtl\r\n"
                               "s off\r\nf 1 2 \\\r\n3#end\r\n"));
  EXPECT_EQ(mesh.positions[2], (Vec3d{0, 1, 0}));
  ASSERT_OK_AND_ASSIGN(const auto old_mac, ReadObj("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3"));
  EXPECT_EQ(old_mac.face_count(), 1u);
}

TEST(ObjReaderTest, ACommentGluedToAWordEndsTheLine) {
  ASSERT_OK_AND_ASSIGN(const auto mesh,
                       ReadObj("v 0 0 0#1 2\nv 1 0 0\nv 0 1 0\nf 1 2 3#top face\n#f 1 2\n"));
  EXPECT_EQ(mesh.face_count(), 1u);
  EXPECT_EQ(mesh.corner_count(), 3u);
}

TEST(ObjReaderTest, NumbersInEveryNotation) {
  ASSERT_OK_AND_ASSIGN(const auto mesh,
                       ReadObj("v 1e-3 -2.5E+2 +.5\nv 1. 0 0 1.0\nv 0 1 0 0.1 0.2 0.3\nf 1 2 3\n"));
  EXPECT_EQ(mesh.positions[0], (Vec3d{1e-3, -250, 0.5}));
  EXPECT_EQ(mesh.positions[2], (Vec3d{0, 1, 0}));  // colours are not coordinates
}

TEST(ObjReaderTest, GroupsAreMaterialsElseGroupsElseObjects) {
  ASSERT_OK_AND_ASSIGN(
      const auto mesh,
      ReadObj(std::string(kTriangle) +
              "f 1 2 3\no thing\nf 1 2 3\ng left wing\nf 1 2 3\nusemtl steel\nf 1 2 3\n"
              "g right\nf 1 2 3\nusemtl unused\n"));
  EXPECT_THAT(mesh.group_names, ElementsAre("default", "thing", "left wing", "steel"));
  EXPECT_THAT(mesh.face_groups, ElementsAre(0, 1, 2, 3, 3));
}

TEST(ObjReaderTest, FilesWithoutGroupsHaveNone) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, ReadObj(std::string(kTriangle) + "f 1 2 3\n"));
  EXPECT_THAT(mesh.group_names, IsEmpty());
  EXPECT_THAT(mesh.face_groups, IsEmpty());
}

struct BadObj {
  const char* text;
  const char* message;
};
class BadObjTest : public ::testing::TestWithParam<BadObj> {};
INSTANTIATE_TEST_SUITE_P(
    All, BadObjTest,
    ::testing::Values(
        BadObj{"", "the mesh has no faces"}, BadObj{"v 0 0 0\n", "the mesh has no faces"},
        BadObj{"\x01\x02\xff binary", "the mesh has no faces"},
        BadObj{"v 0 0\n", "line 1: a number is missing"},
        BadObj{"v 0 0 # 0\n", "line 1: a number is missing"},
        BadObj{"\n\nv 0 zero 0\n", "line 3: 'zero' is not a number"},
        BadObj{"v 0 nan 0\n", "line 1: 'nan' is not finite"},
        BadObj{"v 0 -inf 0\n", "line 1: '-inf' is not finite"},
        BadObj{"v 0 1e999 0\n", "line 1: '1e999'"},
        BadObj{"v 0 1.2.3 0\n", "'1.2.3' is not a number"},
        BadObj{"vn 0 0\n", "line 1: a number is missing"},
        BadObj{"vn 1e39 0 0\n", "line 1: the normal is too long"},
        BadObj{"vt\n", "line 1: a number is missing"}, BadObj{"vt 0 x\n", "line 1: 'x'"},
        BadObj{"vt 1e39\n", "line 1: the texture coordinate is too large"},
        BadObj{"v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: a face has 2 corners; 3 are needed"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
               "line 4: vertex index 4 is out of range; the file has 3"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "line 4: vertex index 0 is out of range"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "line 4: vertex index -4 is out of range"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "line 4: '9999"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n", "line 4: texture coordinate index 1"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//-1 2 3\n", "line 4: normal index -1"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/2/3/4 2 3\n",
               "line 4: '1/2/3/4' has more than three"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 three\n", "line 4: 'three' is not a number"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 1.5\n", "line 4: '1.5' is not an integer"},
        BadObj{"v 0 0 0\nv 1 0 0\nv 1e20 1 0\nf 1 2 3\n", "vertex 2 is farther than 1e+15"}));

TEST_P(BadObjTest, IsRefusedWithItsLine) {
  EXPECT_THAT(ReadObj(GetParam().text), IsMalformed(GetParam().message));
}

TEST(ObjReaderTest, FaceWithTooManyCornersIsRefused) {
  std::string text = std::string(kTriangle) + "f";
  for (int i = 0; i < 65'537; ++i) text += " 1";
  EXPECT_THAT(ReadObj(text), IsMalformed("line 4: a face has more than 65536 corners"));
}

TEST(ObjReaderTest, LineContinuedBeyondFourMebibytesIsRefused) {
  const std::string part(size_t{1} << 20, 'x');
  std::string text = std::string(kTriangle) + "#";
  for (int i = 0; i < 5; ++i) text.append(part).append("\\\n");
  EXPECT_THAT(ReadObj(text + "\nf 1 2 3\n"), IsMalformed("line 4: a continued line of over 4 MiB"));
}

TEST(ObjWriterTest, TrianglesReadBackToTheSameBits) {
  PolygonMesh mesh = testing::SquareOfTwoGroups({1.0 / 3, 1e-17, 123456789.123456789});
  ASSERT_OK_AND_ASSIGN(const auto read, ReadObj(WriteObj(mesh)));
  EXPECT_EQ(testing::CornerPositions(read), testing::CornerPositions(mesh));
  EXPECT_EQ(testing::CornerNormals(read), testing::CornerNormals(mesh));
  EXPECT_EQ(testing::CornerUvs(read), testing::CornerUvs(mesh));
  EXPECT_EQ(read.group_names, mesh.group_names);
  EXPECT_EQ(read.face_groups, mesh.face_groups);
}

TEST(ObjWriterTest, PolygonsReadBackUnchanged) {
  for (std::string_view name : SampleMeshNames()) {
    SCOPED_TRACE(name);
    ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh(name, 2));
    ASSERT_OK_AND_ASSIGN(const auto read, ReadObj(WriteObj(mesh)));
    EXPECT_EQ(read.positions, mesh.positions);
    EXPECT_EQ(read.face_offsets, mesh.face_offsets);
    EXPECT_EQ(read.corner_vertices, mesh.corner_vertices);
    EXPECT_EQ(read.normals, mesh.normals);
    EXPECT_EQ(read.corner_normals, mesh.corner_normals);
    EXPECT_EQ(read.uvs, mesh.uvs);
    EXPECT_EQ(read.corner_uvs, mesh.corner_uvs);
    EXPECT_EQ(read.group_names, mesh.group_names);
    EXPECT_EQ(read.face_groups, mesh.face_groups);
  }
}

TEST(ObjWriterTest, GroupNamesCannotBreakTheFile) {
  PolygonMesh mesh = testing::SquareOfTwoGroups();
  mesh.group_names = {"two\nf 9 9 9", "ends with \\"};
  ASSERT_OK_AND_ASSIGN(const auto read, ReadObj(WriteObj(mesh)));
  EXPECT_THAT(read.group_names, ElementsAre("two_f 9 9 9", "ends with _"));
}

}  // namespace
}  // namespace latticed
