// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl apply with the server in its own process. The identity lattice reproduces the mesh in every
// format, encoding and pipeline. An affine map of the lattice maps the mesh in the same way.
#include <algorithm>
#include <cmath>

#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/output/output.h"
#include "core/mesh/mesh_io.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

double Area(const PolygonMesh& mesh) {
  double area = 0;
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    const uint32_t first = mesh.face_offsets[f];
    for (uint32_t c = first + 1; c + 1 < mesh.face_offsets[f + 1]; ++c) {
      const Vec3d a = mesh.positions[mesh.corner_vertices[first]];
      area += 0.5 * Norm(Cross(mesh.positions[mesh.corner_vertices[c]] - a,
                               mesh.positions[mesh.corner_vertices[c + 1]] - a));
    }
  }
  return area;
}

class LatticectlApply : public LatticectlTest {
 protected:
  void SetUp() override {
    LatticectlTest::SetUp();
    // A unit cube of quads with texture coordinates.
    ASSERT_OK(WriteFile(Path("cube.obj"),
                        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                        "f 4/1 3/2 2/3 1/4\nf 5/1 6/2 7/3 8/4\nf 1/1 2/2 6/3 5/4\n"
                        "f 2/1 3/2 7/3 6/4\nf 3/1 4/2 8/3 7/4\nf 4/1 1/2 5/3 8/4\n"));
    MustRun({"lattice", Path("cube.obj"), "--size", "4,4,4", "-o", Path("L.json")});
  }

  PolygonMesh Apply(const std::string& output, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{
        "apply", Path("cube.obj"), "--lattice", Path("L.json"), "--backend",
        "cpu",   "--segments",     "3",         "-o",           Path(output)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    MustRun(arguments);
    const auto file = ReadMeshFile(Path(output));
    EXPECT_OK(file);
    if (!file.ok()) return {};
    auto mesh = ParseMesh(*file);
    EXPECT_OK(mesh);
    return mesh.ok() ? *std::move(mesh) : PolygonMesh{};
  }

  // Expects all points on the surface of the unit cube, and an area of 6.
  static void ExpectCube(const PolygonMesh& mesh, double tolerance) {
    ASSERT_GE(mesh.face_count(), 48u);  // knot planes cut the 12 triangles
    double worst = 0;
    for (const Vec3d p : mesh.positions) {
      double distance = 1;
      for (int axis = 0; axis < 3; ++axis) {
        distance = std::min({distance, std::abs(p[axis]), std::abs(1 - p[axis])});
      }
      worst = std::max(worst, distance);
    }
    EXPECT_LE(worst, tolerance);
    EXPECT_NEAR(Area(mesh), 6.0, 12 * tolerance);
  }
};

// Any pipeline's error is at most 1e-6 of the cube's diagonal, which is below 3.
constexpr double kFloatTolerance = 1e-6 * 3;
// 12 bits over a range of 2 or 4. Half a step in each of three coordinates is less than one step.
constexpr double kQuantisedTolerance = 4.0 / 4095;

TEST_F(LatticectlApply, IdentityReproducesTheMeshInEveryFormatAndEncoding) {
  struct Case {
    std::string output;
    std::vector<std::string> flags;
    double tolerance = kFloatTolerance;
  };
  const std::vector<Case> cases{
      {"o.ply"},
      {"o.obj"},
      {"o.stl"},
      {"o.glb"},
      {"o.drc", {}, 1.0 / 65535},
      {"o.ply", {"--encoding", "draco"}, kQuantisedTolerance},
      {"o.ply", {"--encoding", "draco-mesh"}, kQuantisedTolerance},
      {"o.ply", {"--encoding", "quantised"}, kQuantisedTolerance},
      {"o.ply", {"--encoding", "meshopt"}, kQuantisedTolerance},
      {"o.ply", {"--encoding", "draco", "--position-bits", "16"}, kQuantisedTolerance / 16},
      {"o.ply", {"--encoding", "patches", "--tolerance", "0.001"}, 2.0 / 65535},
      {"o.ply", {"--pipeline", "control-net"}}};
  for (const auto& [output, flags, tolerance] : cases) {
    SCOPED_TRACE(output + " " + ::testing::PrintToString(flags));
    ExpectCube(Apply(output, flags), tolerance);
  }
}

TEST_F(LatticectlApply, ViewFlagsReachTheServerAndUvsComeFromTheFile) {
  EXPECT_FALSE(Apply("o.ply", {"--normals", "facet"}).normals.empty());
  const PolygonMesh mesh = Apply("o.ply", {"--normals", "none"});
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_TRUE(mesh.has_uvs());
  EXPECT_TRUE(Apply("o.ply", {"--encoding", "patches", "--tolerance", "0.001"}).has_uvs());
}

TEST_F(LatticectlApply, AMovedLatticeMovesTheMeshAndKeepsTheVertexOrder) {
  const PolygonMesh rest = Apply("rest.ply");
  // An affine map of all control points maps the surface in the same way.
  auto lattice = ReadLattice(Path("L.json"));
  ASSERT_OK(lattice);
  for (int i = 0; i + 2 < lattice->control_points_size(); i += 3) {
    const double x = lattice->control_points(i), y = lattice->control_points(i + 1);
    lattice->set_control_points(i, 2 * x + 0.5 * y + 3);
  }
  ASSERT_OK(WriteFile(Path("L.json"), MessageJson(*lattice)));

  const PolygonMesh deformed = Apply("deformed.ply");

  ASSERT_EQ(deformed.positions.size(), rest.positions.size());
  EXPECT_EQ(deformed.corner_vertices, rest.corner_vertices);
  for (size_t i = 0; i < rest.positions.size(); ++i) {
    const Vec3d p = rest.positions[i];
    EXPECT_NEAR(deformed.positions[i].x, 2 * p.x + 0.5 * p.y + 3, 1e-5);
    EXPECT_NEAR(deformed.positions[i].y, p.y, 1e-5);
    EXPECT_NEAR(deformed.positions[i].z, p.z, 1e-5);
  }
}

TEST_F(LatticectlApply, WeightsSayHowFarEachVertexGoes) {
  auto lattice = ReadLattice(Path("L.json"));
  ASSERT_OK(lattice);
  for (int i = 0; i + 2 < lattice->control_points_size(); i += 3) {
    lattice->set_control_points(i, lattice->control_points(i) + 3);
  }
  ASSERT_OK(WriteFile(Path("L.json"), MessageJson(*lattice)));
  const PolygonMesh rest = Apply("follows.ply");
  ASSERT_OK(WriteFile(Path("y.csv"), "weight\n0\n0\n1\n1\n0\n0\n1\n1\n"));  // y of each vertex

  const PolygonMesh deformed = Apply("weighted.ply", {"--weights", Path("y.csv")});

  ASSERT_EQ(deformed.positions.size(), rest.positions.size());
  for (const Vec3d p : deformed.positions) {
    EXPECT_GE(p.x, 3 * p.y - 1e-5);
    EXPECT_LE(p.x, 3 * p.y + 1 + 1e-5);
  }
}

// One of them is turned, so that two kinds of sums are taken.
TEST_F(LatticectlApply, SeveralLatticesAddUp) {
  MustRun({"lattice", Path("cube.obj"), "--turn", "0,0,30", "--box", "-1,-1,-1,2,2,2", "-o",
           Path("turned.json")});
  const auto move_all = [&](const std::string& name, double x, double y) {
    auto lattice = ReadLattice(Path(name));
    ASSERT_OK(lattice);
    for (int i = 0; i < lattice->control_points_size(); i += 3) {
      lattice->set_control_points(i, lattice->control_points(i) + x);
      lattice->set_control_points(i + 1, lattice->control_points(i + 1) + y);
    }
    ASSERT_OK(WriteFile(Path(name), MessageJson(*lattice)));
  };
  move_all("L.json", 1, 0);
  move_all("turned.json", 0.5, 2);
  PolygonMesh exact = Apply("exact.ply", {"--lattice", Path("turned.json")});
  for (Vec3d& p : exact.positions) p = p - Vec3d{1.5, 2, 0};
  ExpectCube(exact, kFloatTolerance);

  MustRun({"apply", Path("cube.obj"), "--lattice", Path("L.json"), "--lattice", Path("turned.json"),
           "--vertices-only", "-o", Path("vertices.obj")});
  const auto vertices = ReadMeshFile(Path("vertices.obj"));
  ASSERT_OK(vertices);
  const auto moved = ParseMesh(*vertices);
  ASSERT_OK(moved);
  ASSERT_EQ(moved->positions.size(), 8u);
  EXPECT_LE(Norm(moved->positions[6] - Vec3d{2.5, 3, 1}), 1e-12);
}

TEST_F(LatticectlApply, BadWeightsAreNamed) {
  ASSERT_OK(WriteFile(Path("few.csv"), "0\n1\n"));
  ASSERT_OK(WriteFile(Path("two.csv"), "0,1\n1,1\n"));
  const auto apply = [&](const std::string& weights) {
    const RunResult result =
        Latticectl({"apply", Path("cube.obj"), "--lattice", Path("L.json"), "--backend", "cpu",
                    "-o", Path("o.ply"), "--weights", weights});
    EXPECT_NE(result.code, 0);
    return result.err;
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(apply(Path("few.csv")), HasSubstr("--weights"));
  EXPECT_THAT(apply(Path("few.csv")), HasSubstr("there are 2 for a mesh of 8 vertices"));
  EXPECT_THAT(apply(Path("two.csv")), HasSubstr("has 2 columns; one is needed"));
  EXPECT_THAT(apply("attribute"), HasSubstr("the mesh's file has none"));
}

}  // namespace
}  // namespace latticed::client
