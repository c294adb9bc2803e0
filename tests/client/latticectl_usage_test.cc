// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <nlohmann/json.hpp>

#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "core/ffd/lattice.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class LatticectlUsage : public LatticectlTest {};

TEST_F(LatticectlUsage, HelpAndVersionAreNoErrors) {
  EXPECT_THAT(MustRun({"--help"}), HasSubstr("apply"));
  EXPECT_THAT(MustRun({"--version"}), HasSubstr("."));
  EXPECT_THAT(MustRun({"apply", "--help"}), HasSubstr("--lattice"));
}

TEST_F(LatticectlUsage, WrongUsageIsTwoAndSaysWhat) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"fly"}, "unknown command 'fly'; 'latticectl --help' shows the commands"},
      {{"apply"}, "required"},
      {{"apply", "a.obj", "--lattice", "l.json"}, "--output"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.xyz"}, "o.xyz"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--backend", "cpu", "--server",
        "h:1"},
       "--server"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--segments", "33"}, "32"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--segments", "0"}, "1"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--normals", "up"}, "smooth"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--encoding", "zip"}, "draco-mesh"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--pipeline", "x"}, "control-net"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--backend", "tpu"}, "cuda"},
      {{"apply", "a.obj", "--lattice", "l.json", "-o", "o.ply", "--up-axis", "w"}, "--up-axis"},
      {{"upload", "a.obj", "--up-axis", "-z"}, "--up-axis"},
      {{"scene", "create", "a.obj", "--crease-angle", "181"}, "--crease-angle"},
      {{"upload", "a.obj", "--meters-per-unit", "0"}, "'0' is not a length above 0"},
      {{"upload", "a.obj", "--meters-per-unit", "inf"}, "'inf' is not a length above 0"},
      {{"upload", "a.obj", "--meters-per-unit", "inch"}, "'inch' is not a length above 0"},
      {{"bench", "knot", "--encoding", "patches"}, "patches have no points to compare"},
      {{"watch", "s", "--tolerance", "0"}, "'0' is not a distance above 0"},
      {{"export", "s", "-o", "a.ply", "--tolerance", "1ft"}, "'1ft' is not a distance above 0"},
      {{"lattice", "a.obj", "--size", "5,4"}, "three whole numbers"},
      {{"lattice", "a.obj", "--degree", "2,x,2"}, "three whole numbers"},
      {{"sample", "teapot", "-o", "x.obj"}, "knot"},
      {{"sample", "knot", "-o", "x.ply"}, ".obj"},
      {{"scene", "show"}, "scene is required; 'latticectl scene show --help' says more"},
      {{"edit", "move", "scene-id", "--point", "1,1,1"}, "--by"},
      {{"edit", "drag", "scene-id", "--ray", "0,0,0,1,0,0"}, "[--to,--by]"},
      {{"edit", "drag", "scene-id", "--by", "1,0,0"}, "[--ray,--at]"},
      {{"pick", "scene-id", "--ray", "0,0,0"}, "--ray"},
      {{"export", "scene-id", "-o", "x.txt"}, ".nets"},
      {{"export", "s", "-o", "x.ply", "--patches", "--original"}, "excludes --patches"},
  };
  for (const auto& [arguments, text] : cases) {
    const RunResult result = Latticectl(arguments);
    EXPECT_EQ(result.code, 2) << text;
    EXPECT_THAT(result.err, StartsWith("latticectl: "));
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_EQ(result.out, "");
  }
}

TEST_F(LatticectlUsage, BenchSaysWhereItsProgramIsMissing) {
  const char* const argv[] = {"latticectl", "bench", "knot", "--edits", "1"};
  std::ostringstream out, err;
  EXPECT_EQ(RunLatticectl(std::size(argv), argv, {.out = out, .err = err}), 1);
  EXPECT_THAT(err.str(),
              ContainsRegex("cannot start the load generator .*/latticectl-bench: No such"));
}

TEST_F(LatticectlUsage, StoreSaysWhereItsProgramIsMissing) {
  const RunResult result = Latticectl({"store", "check", Path("")});
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err,
              ContainsRegex("cannot start the check of a store .*/latticectl-store: No such"));
  EXPECT_EQ(Latticectl({"store", "check"}).code, 2);
}

TEST_F(LatticectlUsage, FileErrorsAreOneAndNameTheFile) {
  ASSERT_OK(WriteFile(Path("bad.obj"), "v 0 0 0\nf 1 2 3\n"));
  ASSERT_OK(WriteFile(Path("empty.obj"), ""));
  ASSERT_OK(WriteFile(Path("bad.drc"), "not draco"));
  ASSERT_OK(WriteFile(Path("good.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  ASSERT_OK(WriteFile(Path("bad.json"), "{\"frame\": 3}"));
  ASSERT_OK(WriteFile(Path("name.json"), "{\"points\": []}"));
  ASSERT_OK(WriteFile(Path("refused.json"),
                      R"({"frame": {"u": {"x": 1}, "v": {"y": 1}, "w": {"z": 1}},
                          "degree": {"u": 2, "v": 0, "w": 2}})"));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"lattice", Path("none.obj")}, "none.obj"},
      {{"lattice", Path("empty.obj")}, "empty"},
      {{"lattice", Path("bad.obj")}, "bad.obj"},
      {{"lattice", Path("bad.drc")}, "bad.drc"},
      {{"lattice", Path("mesh.txt")}, "mesh.txt"},
      {{"lattice", Path("good.obj"), "--degree", "4,2,2"}, "degree"},
      {{"lattice", Path("good.obj"), "--padding", "0"}, "padding"},
      {{"lattice", Path("good.obj"), "-o", Path("no/folder/L.json")}, "cannot write"},
      {{"apply", Path("good.obj"), "--lattice", Path("none.json"), "-o", Path("o.ply")},
       "none.json"},
      {{"apply", Path("good.obj"), "--lattice", Path("bad.json"), "-o", Path("o.ply")}, "bad.json"},
      {{"apply", Path("good.obj"), "--lattice", Path("name.json"), "-o", Path("o.ply")}, "points"},
      {{"apply", Path("good.obj"), "--lattice", Path("refused.json"), "--backend", "cpu", "-o",
        Path("o.ply")},
       "degree.v: got 0, allowed is 1 to 3"},
      {{"upload", Path("none.obj")}, "none.obj"},
      {{"info", "--server", "127.0.0.1:1", "--retry-for", "0"}, "latticed --listen 127.0.0.1:1"},
      {{"scene", "create", Path("good.obj"), "--lattice", Path("bad.json"), "--server",
        "127.0.0.1:1"},
       "bad.json"},
  };
  for (const auto& [arguments, text] : cases) {
    const RunResult result = Latticectl(arguments);
    EXPECT_EQ(result.code, 1) << text;
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
  EXPECT_FALSE(std::filesystem::exists(Path("o.ply")));
}

TEST_F(LatticectlUsage, LatticeIsTheJsonOfTheMessage) {
  ASSERT_OK(WriteFile(Path("mesh.obj"), "v 0.1 0 0\nv 1 0 0.3\nv 0 1 0.7\nf 1 2 3\n"));
  MustRun({"lattice", Path("mesh.obj"), "--size", "5,4,6", "--degree", "2,3,1", "--padding", "0.1",
           "-o", Path("L.json")});
  const auto lattice = ReadLattice(Path("L.json"));
  ASSERT_OK(lattice);

  // The file has the same bits as the fit.
  Bounds bounds;
  for (const Vec3d p : {Vec3d{0.1, 0, 0}, Vec3d{1, 0, 0.3}, Vec3d{0, 1, 0.7}}) bounds.Extend(p);
  const auto expected = FitLattice(bounds, {5, 4, 6}, {2, 3, 1}, 0.1);
  ASSERT_OK(expected);
  ASSERT_EQ(lattice->control_points_size(), 3 * 5 * 4 * 6);
  for (int i = 0; i < lattice->control_points_size(); ++i) {
    EXPECT_EQ(lattice->control_points(i),
              expected->control_points[static_cast<size_t>(i) / 3][i % 3]);
  }
  EXPECT_EQ(lattice->frame().origin().y(), expected->structure.frame.origin.y);
  EXPECT_EQ(lattice->degree().v(), 3);
}

TEST_F(LatticectlUsage, SampleAndLatticeSayInJsonWhatTheyWrote) {
  for (const char* name : {"knot", "gear", "shell", "vase", "slab", "beam"}) {
    const auto sample = nlohmann::json::parse(
        MustRun({"sample", name, "--resolution", "1", "-o", Path("s.obj"), "--json"}));
    EXPECT_EQ(sample["output"], Path("s.obj"));
    EXPECT_GT(sample["vertices"], 0);
    const auto mesh = ParseMesh(*ReadMeshFile(Path("s.obj")));
    ASSERT_OK(mesh);
    EXPECT_EQ(sample["faces"], mesh->face_count()) << name;
  }
  const auto lattice = nlohmann::json::parse(
      MustRun({"lattice", Path("s.obj"), "--size", "4,5,6", "-o", Path("L.json"), "--json"}));
  EXPECT_EQ(lattice["output"], Path("L.json"));
  EXPECT_EQ(lattice["controlPoints"], 120);
}

}  // namespace
}  // namespace latticed::client
