// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/mesh_io.h"

#include <limits>

#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using ::latticed::testing::IsMalformed;
using ::latticed::testing::Raw;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string Facet(const std::vector<float>& vertices) {
  std::string facet = Raw(0.0f) + Raw(0.0f) + Raw(1.0f);
  for (float x : vertices) facet += Raw(x);
  return facet + Raw(uint16_t{0});
}

std::string Binary(const std::string& header, uint32_t count, const std::string& facets) {
  std::string bytes = header;
  bytes.resize(80, '\0');
  return bytes + Raw(count) + facets;
}

const std::string kTwoFacets =
    Facet({0, 0, 0, 1, 0, 0, 1, 1, 0}) + Facet({-0.0f, 0, 0, 1, 1, 0, 0, 1, 0});

constexpr char kAsciiFacet[] =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n "
    "endloop\nendfacet\n";

TEST(StlReaderTest, BinaryVerticesAreWelded) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, ReadStl(Binary("by hand", 2, kTwoFacets)));
  EXPECT_EQ(mesh.positions.size(), 4u);  // -0 is 0
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_FALSE(mesh.has_normals());
  EXPECT_THAT(mesh.group_names, IsEmpty());
}

TEST(StlReaderTest, BinaryThatStartsWithSolid) {
  ASSERT_OK_AND_ASSIGN(const auto exact, ReadStl(Binary("solid but binary", 2, kTwoFacets)));
  EXPECT_EQ(exact.face_count(), 2u);
  ASSERT_OK_AND_ASSIGN(const auto longer, ReadStl(Binary("solid", 2, kTwoFacets + "trailing")));
  EXPECT_EQ(longer.face_count(), 2u);
}

TEST(StlReaderTest, Ascii) {
  ASSERT_OK_AND_ASSIGN(
      const auto mesh,
      ReadStl(
          std::string("solid a part\r\n") + kAsciiFacet +
          "facet normal nan nan nan outer loop vertex 1 0 0 vertex 1e0 1 0 vertex 0 1 0 endloop "
          "endfacet\nendsolid a part\n"));
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2, 1, 3, 2));
  EXPECT_THAT(mesh.group_names, IsEmpty());
}

TEST(StlReaderTest, SolidsAreGroups) {
  const std::string facet = kAsciiFacet;
  ASSERT_OK_AND_ASSIGN(const auto mesh, ReadStl("solid left\n" + facet + "endsolid\nsolid\n" +
                                                facet + facet + "endsolid\n"));
  EXPECT_THAT(mesh.group_names, ElementsAre("left", "solid 2"));
  EXPECT_THAT(mesh.face_groups, ElementsAre(0, 1, 1));
}

TEST(StlReaderTest, BadBinaryFiles) {
  EXPECT_THAT(ReadStl(""), IsMalformed("byte 0: 0 bytes"));
  EXPECT_THAT(ReadStl("nothing"), IsMalformed("byte 0: 7 bytes"));
  EXPECT_THAT(ReadStl(Binary("", 0, "")), IsMalformed("no faces"));
  EXPECT_THAT(ReadStl(Binary("", 3, kTwoFacets)),
              IsMalformed("byte 80: 3 facets need 234 bytes, the file has 184"));
  EXPECT_THAT(ReadStl(Binary("", 0xffffffff, kTwoFacets)),
              IsMalformed("byte 80: 4294967295 facets"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(ReadStl(Binary("", 1, Facet({0, 0, 0, 1, nan, 0, 1, 1, 0}))),
              IsMalformed("byte 84: facet 0 is not finite"));
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_THAT(ReadStl(Binary("", 1, Facet({0, 0, 0, 1, 0, 0, 1, 1, -infinity}))),
              IsMalformed("facet 0 is not finite"));
  EXPECT_THAT(ReadStl(Binary("", 1, Facet({0, 0, 0, 1, 0, 0, 1, 1e20f, 0}))),
              IsMalformed("farther than 1e+15"));
}

TEST(StlReaderTest, BadAsciiFiles) {
  const std::string facet = kAsciiFacet;
  EXPECT_THAT(ReadStl("solid\nendsolid\n"), IsMalformed("no faces"));
  EXPECT_THAT(ReadStl("solid x\n" + facet), IsMalformed("the file ends before endsolid"));
  EXPECT_THAT(ReadStl("solid x\n" + facet.substr(0, 60)), IsMalformed("line 5: "));
  EXPECT_THAT(ReadStl("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 zero 0\n"),
              IsMalformed("line 4: 'zero' is not a number"));
  EXPECT_THAT(ReadStl("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 inf 0\n"),
              IsMalformed("line 4: 'inf' is not finite"));
  EXPECT_THAT(
      ReadStl("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n"),
      IsMalformed("line 6: 'endloop' where vertex belongs"));
  EXPECT_THAT(ReadStl("solid x\nfacet\n"), IsMalformed("the file ends where normal belongs"));
  EXPECT_THAT(ReadStl("solid x\nnonsense\n"), IsMalformed("line 2: 'nonsense' where a facet"));
  EXPECT_THAT(ReadStl("solid x\nendsolid\n" + facet), IsMalformed("a facet outside a solid"));
}

TEST(StlWriterTest, IsBinaryWithUnitNormals) {
  const PolygonMesh mesh = testing::SquareOfTwoGroups();
  const std::string bytes = WriteStl(mesh);
  ASSERT_EQ(bytes.size(), 84u + 2 * 50);
  EXPECT_NE(bytes.substr(0, 5), "solid");
  ASSERT_OK_AND_ASSIGN(const auto read, ReadStl(bytes));
  EXPECT_EQ(testing::CornerPositions(read), testing::CornerPositions(mesh));
  PolygonMesh flat;
  flat.positions = {{0, 0, 0}, {3, 0, 0}, {0, 2, 0}};
  flat.face_offsets = {0, 3};
  flat.corner_vertices = {0, 1, 2};
  EXPECT_EQ(WriteStl(flat).substr(84, 12), Raw(0.0f) + Raw(0.0f) + Raw(1.0f));
}

}  // namespace
}  // namespace latticed
