// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The text of USD files. That a stock reader takes them is tested in tests/client/web/usd_test.ts.
#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(UsdWriterTest, HasFacesPointsAndPrimvarsWithIndices) {
  const std::string text = WriteUsd(testing::SquareOfTwoGroups({2, 0, 0}));

  EXPECT_EQ(text.substr(0, 10), "#usda 1.0\n");
  EXPECT_THAT(text, HasSubstr("double3 xformOp:translate = (2.5, 0.5, 0.25)\n"));
  EXPECT_THAT(text, HasSubstr("int[] faceVertexCounts = [3, 3]\n"));
  EXPECT_THAT(text, HasSubstr("int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\n"));
  EXPECT_THAT(text, HasSubstr("point3f[] points = [(-0.5, -0.5, -0.25), (0.5, -0.5, -0.25), "
                              "(0.5, 0.5, 0.25), (-0.5, 0.5, -0.25)]\n"));
  EXPECT_THAT(text, HasSubstr("float3[] extent = [(-0.5, -0.5, -0.25), (0.5, 0.5, 0.25)]\n"));
  EXPECT_THAT(text, HasSubstr("normal3f[] primvars:normals = [(0, 0, 1), (0, 1, 0), (1, 0, 0), "));
  EXPECT_THAT(text, HasSubstr("texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 0.75), (0.25, 1)]"));
  EXPECT_THAT(text, HasSubstr("int[] primvars:st:indices = [0, 1, 2, 0, 2, 3]\n"));
  EXPECT_THAT(text, Not(HasSubstr("upAxis")));
}

TEST(UsdWriterTest, EachGroupIsASubsetWithAMaterial) {
  PolygonMesh mesh = testing::SquareOfTwoGroups();
  mesh.group_names = {"1 red!", "1 red?"};  // no identifiers, and the same letters
  const std::string text = WriteUsd(mesh);

  EXPECT_THAT(text, HasSubstr("def GeomSubset \"_1_red_\""));
  EXPECT_THAT(text, HasSubstr("int[] indices = [0]\n"
                              "            rel material:binding = </latticed/materials/_1_red_>"));
  EXPECT_THAT(text,
              HasSubstr("int[] indices = [1]\n"
                        "            rel material:binding = </latticed/materials/_1_red__1>"));
  EXPECT_THAT(text, HasSubstr("def Material \"_1_red__1\""));
}

TEST(UsdWriterTest, UnitsAreTheStagesAndXUpIsTurned) {
  const auto with = [](const char* up) {
    return WriteUsd(testing::SquareOfTwoGroups(), {.units = {up, 0.0254}});
  };
  EXPECT_THAT(with("z"), HasSubstr("    metersPerUnit = 0.0254\n    upAxis = \"Z\"\n"));
  EXPECT_THAT(with("y"), HasSubstr("upAxis = \"Y\""));
  EXPECT_THAT(with("y"), Not(HasSubstr("xformOp:transform")));
  EXPECT_THAT(with("x"), HasSubstr("upAxis = \"Y\""));
  EXPECT_THAT(with("x"), HasSubstr("xformOp:transform = ((0, 1, 0, 0), (-1, 0, 0, 0), "));
}

TEST(UsdWriterTest, ACornerWithoutATextureCoordinateGetsZero) {
  PolygonMesh mesh = testing::SquareOfTwoGroups();
  mesh.corner_uvs[4] = PolygonMesh::kNoAttribute;
  const std::string text = WriteUsd(mesh);
  EXPECT_THAT(text, HasSubstr("(0.25, 1), (0, 0)]"));
  EXPECT_THAT(text, HasSubstr("int[] primvars:st:indices = [0, 1, 2, 0, 4, 3]\n"));
}

}  // namespace
}  // namespace latticed
