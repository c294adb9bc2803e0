// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl apply --vertices-only: the vertices follow the definition of the deformation in double, and all else of
// the mesh stays.
#include <cmath>
#include <nlohmann/json.hpp>

#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "core/base/read_file.h"
#include "core/ffd/direct_ffd.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

using ::testing::HasSubstr;

// A deterministic wave, so that no two control points move alike.
Vec3d Moved(Vec3d p) {
  return {p.x + 0.3 * std::sin(5 * p.y), p.y + 0.2 * std::cos(4 * p.z), p.z + 0.25 * p.x * p.x};
}

class LatticectlVertices : public LatticectlTest {
 protected:
  // Writes the lattice that fits the mesh, with moved control points.
  Lattice MakeLattice(const std::string& mesh, const std::string& size,
                      const std::string& degree) const {
    MustRun({"lattice", mesh, "--size", size, "--degree", degree, "-o", Path("L.json")});
    auto proto = ReadLattice(Path("L.json"));
    EXPECT_OK(proto);
    auto lattice = FromProto(*proto);
    EXPECT_OK(lattice);
    for (Vec3d& p : lattice->control_points) p = Moved(p);
    EXPECT_OK(WriteFile(Path("L.json"), MessageJson(ToProto(*lattice))));
    return *std::move(lattice);
  }

  std::string Apply(const std::string& mesh, const std::string& output,
                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"apply", mesh,         "--lattice",      Path("L.json"),
                                       "-o",    Path(output), "--vertices-only"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return MustRun(arguments);
  }

  static PolygonMesh Read(const std::string& path) {
    const auto file = ReadMeshFile(path);
    EXPECT_OK(file);
    auto mesh = ParseMesh(*file);
    EXPECT_OK(mesh);
    return *std::move(mesh);
  }
};

TEST_F(LatticectlVertices, MatchTheDefinitionAndKeepFacesUvsAndGroups) {
  for (const char* name : {"knot", "gear"}) {
    SCOPED_TRACE(name);
    MustRun({"sample", name, "--resolution", "1", "-o", Path("s.obj")});
    const Lattice lattice = MakeLattice(Path("s.obj"), "5,4,6", "3,2,1");
    Apply(Path("s.obj"), "o.obj");

    const PolygonMesh rest = Read(Path("s.obj")), moved = Read(Path("o.obj"));
    ASSERT_EQ(moved.positions.size(), rest.positions.size());
    for (size_t i = 0; i < rest.positions.size(); ++i) {
      const auto expected =
          EvaluateWorld(lattice.structure, lattice.control_points, rest.positions[i]);
      ASSERT_EQ(moved.positions[i], expected.position) << i;  // OBJ keeps all bits
    }
    EXPECT_EQ(moved.face_offsets, rest.face_offsets);
    EXPECT_EQ(moved.corner_vertices, rest.corner_vertices);
    EXPECT_EQ(moved.corner_uvs, rest.corner_uvs);
    EXPECT_EQ(moved.face_groups, rest.face_groups);
    EXPECT_FALSE(moved.has_normals());
  }
}

// A lattice of one box is Sederberg and Parry's: sum_ijk P_ijk B_i(s) B_j(t) B_k(u), cubic Bernstein polynomials B.
TEST_F(LatticectlVertices, OfOneBoxAreBernsteinSums) {
  MustRun({"sample", "shell", "--resolution", "1", "-o", Path("s.obj")});
  const Lattice lattice = MakeLattice(Path("s.obj"), "4,4,4", "3,3,3");
  Apply(Path("s.obj"), "o.obj");

  const auto bernstein = [](int i, double t) {
    return (i == 0 || i == 3 ? 1 : 3) * std::pow(t, i) * std::pow(1 - t, 3 - i);
  };
  const PolygonMesh rest = Read(Path("s.obj")), moved = Read(Path("o.obj"));
  const LatticeFrame& frame = lattice.structure.frame;
  for (size_t v = 0; v < rest.positions.size(); v += 7) {
    const Vec3d from = rest.positions[v] - frame.origin;
    Vec3d expected;
    for (int k = 0; k < 4; ++k) {
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
          expected += bernstein(i, from.x / frame.edges[0].x) *
                      bernstein(j, from.y / frame.edges[1].y) *
                      bernstein(k, from.z / frame.edges[2].z) *
                      lattice.control_points[static_cast<size_t>(lattice.structure.Index(i, j, k))];
        }
      }
    }
    ASSERT_LE(Norm(moved.positions[v] - expected), 1e-13) << v;
  }
}

TEST_F(LatticectlVertices, OutsideTheLatticeStay) {
  ASSERT_OK(WriteFile(Path("unit.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n"));
  const Lattice lattice = MakeLattice(Path("unit.obj"), "4,4,4", "2,2,2");
  // Only the first vertex is inside: the padded frame ends at 1.05.
  ASSERT_OK(WriteFile(Path("s.obj"),
                      "v 0.5 0.5 0.5\nv 1.06 0.5 0.5\nv 0.5 -9 0.5\nv 0.5 0.5 2\nf 1 2 3 4\n"));
  Apply(Path("s.obj"), "o.obj");

  const PolygonMesh moved = Read(Path("o.obj"));
  EXPECT_GT(Norm(moved.positions[0] - Vec3d{0.5, 0.5, 0.5}), 0.05);
  EXPECT_EQ(moved.positions[1], (Vec3d{1.06, 0.5, 0.5}));
  EXPECT_EQ(moved.positions[2], (Vec3d{0.5, -9, 0.5}));
  EXPECT_EQ(moved.positions[3], (Vec3d{0.5, 0.5, 2}));
  EXPECT_EQ(moved.face_count(), 1u);
}

TEST_F(LatticectlVertices, OtherFormatsHaveUvsAndPlyKeepsPolygons) {
  ASSERT_OK(WriteFile(Path("s.obj"),
                      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\n"
                      "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                      "f 1/1 2/2 3/3 4/4\nf 1/4 4/1 5/2\n"));
  MakeLattice(Path("s.obj"), "4,4,4", "2,2,2");
  for (const char* output : {"o.ply", "o.glb", "o.stl", "o.drc"}) {
    SCOPED_TRACE(output);
    const auto json =
        nlohmann::json::parse(Apply(Path("s.obj"), output, {"--json", "--up-axis", "z"}));
    EXPECT_EQ(json["faces"], 2);
    EXPECT_EQ(json["vertices"], 5);
    const PolygonMesh moved = Read(Path(output));
    EXPECT_EQ(moved.face_count(), output == std::string("o.ply") ? 2u : 3u);
    EXPECT_EQ(moved.has_uvs(), output != std::string("o.stl"));
  }
}

TEST_F(LatticectlVertices, OfAGlbAreInMetresAndYUp) {
  ASSERT_OK(WriteFile(Path("s.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n"));
  MakeLattice(Path("s.obj"), "4,4,4", "2,2,2");
  Apply(Path("s.obj"), "s.glb");
  const auto comment = [&](const std::string& mesh, const std::vector<std::string>& flags) {
    Apply(Path(mesh), "o.obj", flags);
    const std::string obj = *ReadFile(Path("o.obj"));
    return obj.starts_with("# up") ? obj.substr(0, obj.find('\n')) : "";
  };
  EXPECT_EQ(comment("s.glb", {}), "# up +y, 1 m per unit");
  EXPECT_EQ(comment("s.glb", {"--up-axis", "z"}), "# up +z, 1 m per unit");
  EXPECT_EQ(comment("s.glb", {"--meters-per-unit", "0.01"}), "# up +y, 0.01 m per unit");
  EXPECT_EQ(comment("s.obj", {}), "");
}

TEST_F(LatticectlVertices, PrintsCountsAndRefusesFlagsOfTheServer) {
  MustRun({"sample", "knot", "--resolution", "1", "-o", Path("s.obj")});
  MakeLattice(Path("s.obj"), "4,4,4", "2,2,2");
  EXPECT_THAT(Apply(Path("s.obj"), "o.obj"), HasSubstr("360 vertices moved, 360 faces"));
  const auto json = nlohmann::json::parse(Apply(Path("s.obj"), "o.obj", {"--json"}));
  EXPECT_EQ(json["vertices"], 360);
  EXPECT_EQ(json["faces"], 360);

  const std::vector<std::vector<std::string>> refused{
      {"--segments", "3"},     {"--normals", "none"}, {"--encoding", "raw"},
      {"--pipeline", "fused"}, {"--server", "h:1"},   {"--backend", "cpu"}};
  for (const auto& flag : refused) {
    std::vector<std::string> arguments{"apply", "a.obj", "--lattice",      "L.json",
                                       "-o",    "o.ply", "--vertices-only"};
    arguments.insert(arguments.end(), flag.begin(), flag.end());
    const RunResult result = Latticectl(arguments);
    EXPECT_EQ(result.code, 2);
    EXPECT_THAT(result.err, HasSubstr("--vertices-only"));
    EXPECT_THAT(result.err, HasSubstr(flag[0]));
  }
}

TEST_F(LatticectlVertices, RefuseALatticeAsTheServerDoes) {
  ASSERT_OK(WriteFile(Path("s.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  const std::string frame = R"("frame": {"u": {"x": 1}, "v": {"y": 1}, "w": {"z": 1}})";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"{}", "--lattice, frame: is required"},
      {"{" + frame + R"(, "degree": {"u": 2, "v": 0, "w": 2}})", "degree.v: got 0, allowed is 1"},
      {"{" + frame + R"(, "controlPoints": [1, 2]})", "got 2 numbers"},
      {"{" + frame + R"(, "controlPoints": [1, 2, 3]})", "got 1 points, size u * v * w = 64"}};
  for (const auto& [json, text] : cases) {
    ASSERT_OK(WriteFile(Path("L.json"), json));
    const RunResult result = Latticectl({"apply", Path("s.obj"), "--lattice", Path("L.json"), "-o",
                                         Path("o.obj"), "--vertices-only"});
    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, HasSubstr(text));
  }
}

}  // namespace
}  // namespace latticed::client
