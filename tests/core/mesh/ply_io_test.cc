// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/mesh_io.h"

#include <cmath>
#include <limits>

#include "core/mesh/sample_meshes.h"
#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using ::latticed::testing::IsMalformed;
using ::latticed::testing::Raw;
using ::testing::ElementsAre;

std::string AsciiHeader(const std::string& vertices, const std::string& faces) {
  return "ply\nformat ascii 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}
constexpr char kThreeVertices[] = "0 0 0\n1 0 0\n0 1 0\n";

TEST(PlyReaderTest, AsciiWithPolygonsCommentsAndCrlf) {
  ASSERT_OK_AND_ASSIGN(
      const auto mesh,
      ReadPly(
          "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info none\r\nelement vertex 4\r\n"
          "property double x\r\nproperty float64 y\r\nproperty float32 z\r\nelement face 2\r\n"
          "property list uint8 int32 vertex_index\r\nend_header\r\n"
          "0 0 0\r\n1e0 0 0\r\n1 1 0\r\n0 1 -.5\r\n4 0 1 2 3\r\n3 0 2 3\r\n"));
  EXPECT_THAT(mesh.face_offsets, ElementsAre(0, 4, 7));
  EXPECT_EQ(mesh.positions[3], (Vec3d{0, 1, -0.5}));
}

TEST(PlyReaderTest, ExtraElementsPropertiesAndListsAnywhere) {
  ASSERT_OK_AND_ASSIGN(
      const auto mesh,
      ReadPly(
          "ply\nformat ascii 1.0\nelement camera 1\nproperty float fov\nproperty list uchar float "
          "view\n"
          "element face 1\nproperty uchar red\nproperty list uchar float weights\n"
          "property list uchar uint vertex_indices\nproperty list uchar float texcoord\n"
          "element vertex 3\nproperty uchar red\nproperty float z\nproperty list uchar int tags\n"
          "property float y\nproperty float x\nproperty short quality\nelement empty "
          "7\nend_header\n"
          "60 2 1 2\n255 1 0.5 3 0 1 2 6 0 0 1 0 1 1\n9 0 2 7 7 0 0 1\n9 0 0 0 1 1\n9 0 1 5 1 0 "
          "-1\n"));
  EXPECT_THAT(mesh.positions, ElementsAre(Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}));
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2));
}

TEST(PlyReaderTest, WeightsAsTheyAreWritten) {
  const auto read = [](const std::string& weights) {
    return ReadPly(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nproperty double weight\nelement face 1\nproperty list uchar int "
        "vertex_indices\nend_header\n" +
        weights + "3 0 1 2\n");
  };
  ASSERT_OK_AND_ASSIGN(const auto mesh, read("0 0 0 0.25\n1 0 0 1\n0 1 0 7\n"));
  EXPECT_THAT(mesh.weights, ElementsAre(0.25f, 1.0f, 7.0f));
  EXPECT_THAT(read("0 0 0 0.25\n1 0 0 nan\n0 1 0 7\n"), IsMalformed("nan"));
}

TEST(PlyReaderTest, NormalsAndEveryNameOfUvs) {
  for (const char* uv : {"s t", "u v", "texture_u texture_v"}) {
    const std::string u = std::string(uv).substr(0, std::string(uv).find(' '));
    const std::string v = std::string(uv).substr(std::string(uv).find(' ') + 1);
    ASSERT_OK_AND_ASSIGN(
        const auto mesh,
        ReadPly(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
            "float z\n"
            "property float nx\nproperty float ny\nproperty float nz\nproperty float " +
            u + "\nproperty float " + v +
            "\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 0 0 1 .5 .25\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n3 0 1 2\n"));
    EXPECT_EQ(mesh.normals[1], (Vec3f{0, 0, 1}));
    EXPECT_EQ(mesh.uvs[0], (Vec2f{0.5f, 0.25f})) << uv;
    EXPECT_EQ(mesh.corner_normals, mesh.corner_vertices);
    EXPECT_EQ(mesh.corner_uvs, mesh.corner_vertices);
  }
}

std::string BinaryPly(bool big) {
  std::string bytes =
      "ply\nformat binary_" + std::string(big ? "big" : "little") +
      "_endian 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty int z\n"
      "property list ushort short extra\nelement face 1\nproperty char flag\n"
      "property list uint ushort vertex_indices\nend_header\n";
  const auto vertex = [&](double x, float y, int32_t z) {
    bytes += Raw(x, big) + Raw(y, big) + Raw(z, big) + Raw(uint16_t{2}, big) +
             Raw(int16_t{-1}, big) + Raw(int16_t{258}, big);
  };
  vertex(0.1, 0, 0), vertex(1, -2.5f, 0), vertex(0, 1, -70000);
  bytes += Raw(int8_t{-1}) + Raw(uint32_t{3}, big);
  for (uint16_t i : {2, 1, 0}) bytes += Raw(i, big);
  return bytes;
}

TEST(PlyReaderTest, BinaryOfBothEndians) {
  for (const bool big : {false, true}) {
    ASSERT_OK_AND_ASSIGN(const auto mesh, ReadPly(BinaryPly(big)));
    EXPECT_THAT(mesh.positions,
                ElementsAre(Vec3d{0.1, 0, 0}, Vec3d{1, -2.5, 0}, Vec3d{0, 1, -70000}));
    EXPECT_THAT(mesh.corner_vertices, ElementsAre(2, 1, 0));
  }
}

TEST(PlyReaderTest, EveryTruncationOfABinaryFileIsRefused) {
  for (const bool big : {false, true}) {
    const std::string bytes = BinaryPly(big);
    for (size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_THAT(ReadPly(std::string_view(bytes).substr(0, size)), IsMalformed("PLY")) << size;
    }
  }
}

TEST(PlyReaderTest, TriangleStripsAsInStanfordScans) {
  ASSERT_OK_AND_ASSIGN(
      const auto mesh,
      ReadPly("ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float "
              "y\nproperty float "
              "z\n"
              "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
              "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n11 0 1 2 3 4 -1 -1 4 3 2 -1\n"));
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 2));
}

TEST(PlyReaderTest, DegenerateTrianglesOfStripsOnlyJoinThem) {
  ASSERT_OK_AND_ASSIGN(
      const auto mesh,
      ReadPly("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
              "y\nproperty float "
              "z\n"
              "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
              "0 0 0\n1 0 0\n0 1 0\n1 1 0\n5 0 1 2 2 3\n"));
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2));
}

struct BadPly {
  std::string text;
  const char* message;
};
class BadPlyTest : public ::testing::TestWithParam<BadPly> {};
INSTANTIATE_TEST_SUITE_P(
    All, BadPlyTest,
    ::testing::Values(
        BadPly{"", "line 1: the first line is not 'ply'"},
        BadPly{"plx\n", "line 1: the first line is not 'ply'"},
        BadPly{"ply\nformat ascii 1.0\n", "the file ends before end_header"},
        BadPly{"ply\nend_header\n", "no format line"},
        BadPly{"ply\nformat text 1.0\n", "line 2: 'text' is no format"},
        BadPly{"ply\nformat ascii 2.0\n", "line 2: version '2.0' is not 1.0"},
        BadPly{"ply\nformat ascii 1.0\nrubbish\n", "line 3: 'rubbish' is no header keyword"},
        BadPly{"ply\nformat ascii 1.0\nproperty float x\n",
               "line 3: a property before any element"},
        BadPly{"ply\nformat ascii 1.0\nelement vertex -1\n", "line 3: -1 elements"},
        BadPly{"ply\nformat ascii 1.0\nelement vertex many\n", "line 3: 'many' is not a number"},
        BadPly{"ply\nformat ascii 1.0\nelement\n", "line 3: an element has no name"},
        BadPly{"ply\nformat ascii 1.0\nelement a 1\nproperty real x\n",
               "line 4: 'real' is no type"},
        BadPly{"ply\nformat ascii 1.0\nelement a 1\nproperty float\n", "a property has no name"},
        BadPly{"ply\nformat ascii 1.0\nelement a 1\nproperty list float int x\n",
               "a list's length is no integer"},
        BadPly{"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "no element 'vertex'"},
        BadPly{"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n",
               "lack one of x, y, z"},
        BadPly{AsciiHeader("0", "0"), "no faces"},
        BadPly{AsciiHeader("3", "0") + kThreeVertices, "no faces"},
        BadPly{AsciiHeader("3", "1") + "0 0 0\n1 0 0\n0 one 0\n3 0 1 2\n",
               "line 12: 'one' is not a number"},
        BadPly{AsciiHeader("3", "1") + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n",
               "line 12: 'nan' is not finite"},
        BadPly{AsciiHeader("3", "1") + "0 0 0\n1 0 0\n0 1e39 0\n3 0 1 2\n",
               "a vertex's 'y' is not finite"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "3 0 1 3\n",
               "line 13: vertex index 3 is out of range; the file has 3"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "3 0 1 -1\n",
               "vertex index -1 is out of range"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "3 0 1 1.5\n", "'1.5' is not an integer"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "2 0 1\n",
               "a face has 2 corners; 3 are needed"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "-3 0 1 2\n", "a list has the length -3"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "1e300 0 1 2\n", "a list has the length"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "200 0 1 2\n", "a list of 200 values in"},
        BadPly{AsciiHeader("3", "1") + kThreeVertices + "3 0 1\n", "the file ends too early"},
        BadPly{AsciiHeader("4000000000", "1") + kThreeVertices, "at most 200000000 are allowed"},
        BadPly{AsciiHeader("100000000", "1") + kThreeVertices, "need more bytes than the"},
        BadPly{AsciiHeader("3", "99999999") + kThreeVertices + "3 0 1 2\n",
               "need more bytes than the"}));

TEST_P(BadPlyTest, IsRefusedWithItsLine) {
  EXPECT_THAT(ReadPly(GetParam().text), IsMalformed(GetParam().message));
}

TEST(PlyReaderTest, BinaryNumbersThatAreNotFiniteAreRefused) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";
  for (float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_THAT(ReadPly(header + Raw(0.0f) + Raw(bad) + Raw(0.0f)),
                IsMalformed("a vertex's 'y' is not finite"));
  }
}

TEST(PlyReaderTest, FacesWithoutIndicesAreRefused) {
  const std::string start =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\n";
  EXPECT_THAT(ReadPly(start + "element face 1\nproperty int material\nend_header\n0 0 0\n1\n"),
              IsMalformed("'face' has no list vertex_indices"));
  EXPECT_THAT(
      ReadPly(start +
              "element face 1\nproperty list uchar float vertex_indices\nend_header\n0 0 0\n1 0\n"),
      IsMalformed("vertex_indices are not integers"));
}

TEST(PlyWriterTest, HasExactlyTheStatedLayout) {
  const PolygonMesh mesh = testing::SquareOfTwoGroups();
  const std::string bytes = WritePly(mesh);
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment latticed\nelement vertex 4\nproperty float x\n"
      "property float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float "
      "nz\n"
      "property float s\nproperty float t\nelement face 2\nproperty list uchar int vertex_indices\n"
      "end_header\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  EXPECT_EQ(bytes.size(), header.size() + 4 * 32 + 2 * 13);
  ASSERT_OK_AND_ASSIGN(const auto read, ReadPly(bytes));
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.normals, mesh.normals);
  EXPECT_EQ(read.uvs, mesh.uvs);
  EXPECT_THAT(read.corner_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
}

TEST(PlyWriterTest, PolygonsStayPolygons) {
  ASSERT_OK_AND_ASSIGN(const auto beam, MakeSampleMesh("beam", 2));
  ASSERT_OK_AND_ASSIGN(const auto read, ReadPly(WritePly(beam)));
  EXPECT_EQ(read.face_offsets, beam.face_offsets);
  EXPECT_EQ(testing::CornerPositions(read), testing::CornerPositions(beam));
  EXPECT_EQ(testing::CornerUvs(read), testing::CornerUvs(beam));
}

TEST(PlyWriterTest, AFaceOfMoreThan255CornersHasALongerCount) {
  PolygonMesh mesh;
  mesh.face_offsets = {0, 300};
  for (uint32_t i = 0; i < 300; ++i) {
    const double angle = i / 300.0 * 6.28;
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
    mesh.corner_vertices.push_back(i);
  }
  ASSERT_OK_AND_ASSIGN(const auto read, ReadPly(WritePly(mesh)));
  EXPECT_EQ(read.face_offsets, mesh.face_offsets);
  EXPECT_EQ(read.corner_vertices, mesh.corner_vertices);
}

TEST(PlyWriterTest, LeavesOutWhatTheMeshHasNot) {
  PolygonMesh mesh = testing::SquareOfTwoGroups();
  mesh.normals.clear();
  mesh.corner_normals.clear();
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  const std::string bytes = WritePly(mesh);
  EXPECT_EQ(bytes.find("property float nx"), std::string::npos);
  EXPECT_EQ(bytes.find("property float s"), std::string::npos);
  EXPECT_OK(ReadPly(bytes));
}

}  // namespace
}  // namespace latticed
