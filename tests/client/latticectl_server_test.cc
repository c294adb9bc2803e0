// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The commands that need a running server, against one in this process, which they reach by its address.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/base/read_file.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class LatticectlServerTest : public LatticectlServer {
 protected:
  void MakeScene() {
    Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--segments", "2"});
  }
};

TEST_F(LatticectlServerTest, InfoSaysWhatTheServerIs) {
  const std::string info = Run({"info"});
  for (const char* text : {"cpu", "0, while slow readers", "0, because host memory was short",
                           "connections           up to "}) {
    EXPECT_THAT(info, HasSubstr(text));
  }
  EXPECT_THAT(info, ContainsRegex("best encoding         (draco|meshopt): meshopt's 0.2 bytes more "
                                  "a point take [0-9.]+ ns at [0-9.]+ MB/s, decoding saves "));
  EXPECT_EQ(RunJson({"info"})["limits"]["maxSegments"], 32);
}

TEST_F(LatticectlServerTest, InfoSaysWhetherARestartLosesAnything) {
  EXPECT_THAT(Run({"info"}), HasSubstr("durability            none: meshes and scenes end"));
  EXPECT_FALSE(RunJson({"info"}).value("durable", false));

  Options options = QuietOptions();
  options.data_dir = Path("data");
  const auto durable = StartServer(options);
  ASSERT_NE(durable, nullptr);
  EXPECT_THAT(MustRun({"info", "--server", durable->address()}),
              HasSubstr("durability            meshes, scenes and edits survive a restart\n"));
}

TEST_F(LatticectlServerTest, ASceneShowsItsUnits) {
  MakeScene();
  EXPECT_THAT(Run({"scene", "show", "scene-one"}), HasSubstr("units                unknown\n"));

  Run({"scene", "create", Path("vase.obj"), "--id", "scene-two", "--up", "y", "--meters-per-unit",
       "0.01"});
  EXPECT_THAT(Run({"scene", "show", "scene-two"}), HasSubstr("up +y, 0.01 m per unit\n"));
  Run({"export", "scene-two", "-o", Path("up.obj")});
  const auto obj = ReadFile(Path("up.obj"));
  ASSERT_OK(obj);
  EXPECT_THAT(obj->substr(0, 100), HasSubstr("up +y, 0.01 m per unit"));
}

TEST_F(LatticectlServerTest, ABeamStaysABoxUnlessItsCreasesAreSmoothed) {
  MustRun({"sample", "beam", "-o", Path("beam.obj")});
  MustRun({"lattice", Path("beam.obj"), "-o", Path("L.json")});
  // The lattice is at rest, so the first number of each normal is -1, 0 or 1 on a box.
  const auto slanted = [&](const std::vector<std::string>& creases) {
    std::vector<std::string> line{"apply",     Path("beam.obj"), "--lattice", Path("L.json"),
                                  "--normals", "smooth",         "-o",        Path("o.obj")};
    line.insert(line.end(), creases.begin(), creases.end());
    Run(line);
    std::istringstream obj(*ReadFile(Path("o.obj")));
    int normals = 0, count = 0;
    for (std::string word; obj >> word;) {
      double x = 0;
      if (word != "vn" || !(obj >> x)) continue;
      ++normals;
      const double nearest = std::min({std::abs(x + 1), std::abs(x), std::abs(x - 1)});
      if (nearest > 0.01) ++count;
    }
    EXPECT_GT(normals, 100);
    return count;
  };
  EXPECT_EQ(slanted({}), 0);
  EXPECT_EQ(slanted({"--crease-angle", "89"}), 0);
  EXPECT_GT(slanted({"--crease-angle", "180"}), 100);

  Run({"scene", "create", Path("beam.obj"), "--id", "scene-two", "--crease-angle", "45"});
  EXPECT_THAT(Run({"scene", "show", "scene-two"}), HasSubstr("crease angle         45 degrees\n"));
}

TEST_F(LatticectlServerTest, HealthIsToldByTheExitCodeAndNeedsNoToken) {
  Options options = QuietOptions();
  options.token_file = Path("tokens");
  options.drain_delay = absl::Seconds(5);  // enough for a machine that stalls
  ASSERT_OK(WriteFile(options.token_file, std::string(64, 'a') + " admin somebody\n"));
  const auto server = StartServer(options);
  const auto health = [&] {
    return Latticectl({"info", "--health", "--server", server->address()});
  };

  EXPECT_EQ(Run({"info", "--health"}), "serving\n");
  EXPECT_EQ(health().code, 0);
  std::thread drain([&] { server->Drain(); });
  RunResult draining = health();
  while (draining.code == 0) draining = health();
  drain.join();

  EXPECT_EQ(draining.code, 1);
  EXPECT_THAT(draining.err, HasSubstr("the server says NOT_SERVING"));
  EXPECT_EQ(health().code, 1) << "nobody listens there any more";
}

TEST_F(LatticectlServerTest, UploadsAndListsMeshes) {
  const auto mesh = RunJson({"upload", Path("vase.obj"), "--label", "kind=vase"});
  EXPECT_EQ(mesh["name"], "vase.obj");
  EXPECT_EQ(mesh["labels"]["kind"], "vase");
  EXPECT_THAT(Run({"meshes"}), HasSubstr(mesh["id"].get<std::string>()));
  EXPECT_EQ(RunJson({"meshes"}).size(), 1u);
  EXPECT_EQ(RunJson({"meshes", "--filter", "kind=pot"}).size(), 0u);
}

TEST_F(LatticectlServerTest, UploadDoesNotPassOverTheUnitsThatAMeshHasAlready) {
  const std::string vase = Path("vase.obj");
  EXPECT_EQ(RunJson({"upload", vase, "--up-axis", "z"})["upAxis"], "UP_AXIS_Z");
  Run({"upload", vase, "--up-axis", "z"});
  Run({"upload", vase});
  const auto stays = HasSubstr("already exists with up +z, which does not change");
  ExpectFailure({"upload", vase, "--up-axis", "y"}, stays);
  ExpectFailure({"upload", vase, "--meters-per-unit", "1"}, stays);
}

TEST_F(LatticectlServerTest, ApplyWritesTheUnitsAskedForAlsoOfAMeshThatWasThere) {
  MustRun({"lattice", Path("vase.obj"), "-o", Path("L.json")});
  const auto apply = [&](const std::string& axis) {
    Run({"apply", Path("vase.obj"), "--lattice", Path("L.json"), "--segments", "1", "--up-axis",
         axis, "--meters-per-unit", "0.001", "-o", Path("o.ply")});
    return ReadFile(Path("o.ply"));
  };
  EXPECT_THAT(*apply("z"), HasSubstr("up +z, 0.001 m per unit"));
  Run({"upload", Path("vase.obj"), "--up-axis", "x"});
  EXPECT_THAT(*apply("y"), HasSubstr("up +y, 0.001 m per unit"));
}

TEST_F(LatticectlServerTest, DeletesMeshesThatNoSceneUses) {
  MakeScene();
  const std::string vase = RunJson({"scene", "show", "scene-one"})["mesh"];
  MustRun({"sample", "gear", "--resolution", "1", "-o", Path("gear.obj")});
  const std::string gear = RunJson({"upload", Path("gear.obj")})["id"];

  const RunResult refused = Latticectl(AtServer({"meshes", "delete", gear, vase, "--json"}));
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("MESH_IN_USE"));
  EXPECT_EQ(nlohmann::json::parse(refused.out)["deleted"], nlohmann::json({gear}));
  EXPECT_EQ(RunJson({"meshes"}).size(), 1u);

  EXPECT_EQ(RunJson({"scene", "delete", "scene-one"})["deleted"], nlohmann::json({"scene-one"}));
  EXPECT_EQ(Run({"meshes", "delete", vase}), "mesh " + vase + " is deleted\n");
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);
}

TEST_F(LatticectlServerTest, ScenesAreMadeShownListedAndDeleted) {
  MakeScene();
  EXPECT_EQ(RunJson({"scene", "show", "scene-one"})["defaultView"]["segments"], 2);
  EXPECT_THAT(Run({"scene", "show", "scene-one"}), HasSubstr("patches"));
  EXPECT_THAT(Run({"scene", "list"}), AllOf(HasSubstr("scene-one"), HasSubstr("  vase  ")));
  Run({"scene", "delete", "scene-one"});
  ExpectFailure(
      {"scene", "show", "scene-one"},
      AllOf(HasSubstr("scene-one"), HasSubstr("'latticectl scene list' shows what there is"),
            HasSubstr("(NOT_FOUND, request ")));
}

TEST_F(LatticectlServerTest, ResizesAndReplacesTheLatticeOfAScene) {
  MakeScene();
  const auto size = [&] { return RunJson({"scene", "show", "scene-one"})["lattices"][0]["size"]; };
  const nlohmann::json first = size();
  Run({"edit", "move", "scene-one", "--point", "0,0,0", "--by", "0.5,0,0"});
  EXPECT_THAT(Run({"edit", "resize", "scene-one", "--size", "8,8,8", "--degree", "3,3,3"}),
              HasSubstr("the shape changed by about "));
  EXPECT_EQ(size()["u"], 8);
  // An axis that does not change keeps its knots.
  Run({"edit", "insert-knot", "scene-one", "u", "0.1"});
  EXPECT_THAT(Run({"edit", "resize", "scene-one", "--size", "9,8,12"}),
              HasSubstr("the shape changed by about "));
  EXPECT_EQ(size()["w"], 12);
  Run({"edit", "undo", "scene-one"});
  Run({"edit", "undo", "scene-one"});
  ExpectFailure({"edit", "resize", "scene-one"}, HasSubstr("--size or --degree is needed"));
  MustRun({"lattice", Path("vase.obj"), "--size", "3,4,5", "-o", Path("L.json")});
  Run({"edit", "replace", "scene-one", "--lattice", Path("L.json")});
  EXPECT_EQ(size()["w"], 5);
  Run({"edit", "undo", "scene-one"});
  Run({"edit", "undo", "scene-one"});
  EXPECT_EQ(size(), first);
  MustRun({"lattice", Path("vase.obj"), "--padding", "0.3", "-o", Path("L.json")});
  ExpectFailure({"edit", "replace", "scene-one", "--lattice", Path("L.json"), "--keep-shape"},
                HasSubstr("--lattice, frame: must be the scene's to keep the shape"));
  ExpectFailure({"edit", "resize", "scene-one", "--size", "2,2,2"}, HasSubstr("--size, u: got 2"));
}

TEST_F(LatticectlServerTest, MeasuresAndKeepsTheVolume) {
  MakeScene();  // of a vase, which is closed
  const auto volume = [this] {
    return RunJson({"measure", "scene-one", "--volume"})["volume"].get<double>();
  };
  const double rest = volume();
  EXPECT_THAT(Run({"measure", "scene-one"}),
              ::testing::AllOf(HasSubstr("volume "), HasSubstr("area "), HasSubstr("centroid "),
                               HasSubstr("bounds ")));
  EXPECT_EQ(RunJson({"measure", "scene-one", "--area", "--gradient"})["areaGradient"].size() % 3,
            0u);
  ExpectFailure({"measure", "scene-one", "--volume", "--lattice-number", "1"},
                HasSubstr("lattice: got 1"));

  Run({"edit", "constrain", "scene-one", "--keep-volume", "--volume-axis", "w", "--layers", "w-1",
       "--mirror", "u", "--point", "1,1,1"});
  Run({"edit", "move", "scene-one", "--point", "1,2,2", "--by", "0.2,0.1,0.3"});

  EXPECT_NEAR(volume() / rest, 1, 1e-12);
  ExpectFailure({"edit", "constrain", "scene-one", "--point", "9,1,1"}, HasSubstr("--point 9,1,1"));
  ExpectFailure({"edit", "constrain", "scene-one", "--volume", "0"}, HasSubstr("must not be 0"));
}

TEST_F(LatticectlServerTest, PicksAndDragsPointsOfTheSurface) {
  MakeScene();
  const std::string ray = "5,0.1,0.1,-1,0,0";
  const auto x_of = [](const nlohmann::json& point) {
    return point["position"]["x"].get<double>();
  };
  const auto point = RunJson({"pick", "scene-one", "--ray", ray});
  const std::string text = Run({"pick", "scene-one", "--ray", ray});
  const size_t begin = text.find("edit drag --at ") + 15;
  const std::string at = text.substr(begin, text.find('\n', begin) - begin);

  EXPECT_THAT(Run({"edit", "drag", "scene-one", "--at", at, "--by", "0.25,0,0"}),
              HasSubstr("distance left to the target: "));
  const auto dragged = RunJson({"pick", "scene-one", "--ray", ray});
  EXPECT_NEAR(x_of(dragged), x_of(point) + 0.25, 1e-9);
  EXPECT_NEAR(dragged["position"]["y"].get<double>(), 0.1, 1e-9);
  Run({"edit", "drag", "scene-one", "--ray", ray, "--to", "3,0.1,0.1"});
  EXPECT_NEAR(x_of(RunJson({"pick", "scene-one", "--ray", ray})), 3, 1e-9);

  ExpectFailure({"pick", "scene-one", "--ray", "9,9,9,1,0,0"}, HasSubstr("NOTHING_HIT"));
  ExpectFailure({"edit", "drag", "scene-one", "--at", "0.5,0,1,2,1,0,0", "--by", "1,0,0"},
                HasSubstr("--at: 0.5 is not the index of a face"));
}

TEST_F(LatticectlServerTest, AParentCarriesControlPoints) {
  MakeScene();
  MustRun({"lattice", Path("vase.obj"), "--size", "3,3,3", "--padding", "1", "-o", Path("P.json")});
  auto parent = nlohmann::json::parse(*ReadFile(Path("P.json")));
  for (size_t i = 0; i < parent["controlPoints"].size(); i += 3) {
    parent["controlPoints"][i] = parent["controlPoints"][i].template get<double>() + 2;
  }
  ASSERT_OK(WriteFile(Path("P.json"), parent.dump()));

  EXPECT_THAT(Run({"edit", "carry", "scene-one", "--lattice", Path("P.json"), "--point", "0,0,1"}),
              HasSubstr("revision 1: "));
  EXPECT_THAT(Run({"edit", "carry", "scene-one", "--lattice", Path("P.json")}),
              HasSubstr("largest move 2"));
  EXPECT_EQ(RunJson({"edit", "undo", "scene-one"})["revision"], "3");
  ExpectFailure({"edit", "carry", "scene-one", "--lattice", Path("P.json"), "--point", "4,0,0"},
                HasSubstr("4 x 4 x 4"));
}

TEST_F(LatticectlServerTest, EditsRaiseTheRevision) {
  MakeScene();
  const std::vector<std::vector<std::string>> edits{
      {"move", "scene-one", "--point", "1,1,1", "--point", "2,1,1", "--by", "0.5,0,0"},
      {"set", "scene-one", "--point", "0,0,3", "--to", "1,-2,3"},
      {"insert-knot", "scene-one", "w", "0.5"},
      {"undo", "scene-one"},
      {"redo", "scene-one"}};
  int revision = 0;
  for (std::vector<std::string> edit : edits) {
    edit.insert(edit.begin(), "edit");
    EXPECT_THAT(Run(edit), HasSubstr("revision " + std::to_string(++revision))) << edit[1];
  }
  EXPECT_EQ(RunJson({"edit", "reset", "scene-one"})["revision"], "6");
  ExpectFailure({"edit", "move", "scene-one", "--point", "4,0,0", "--by", "1,0,0"},
                HasSubstr("4 x 4 x 5"));
}

TEST_F(LatticectlServerTest, WatchPrintsALineForAnUpdate) {
  MakeScene();
  EXPECT_THAT(Run({"watch", "scene-one", "--updates", "1"}), HasSubstr("revision 0"));
  EXPECT_GT(RunJson({"watch", "scene-one", "--updates", "1"})["bytes"], 0);
  constexpr char kChosen[] = "latticectl: by (draco|meshopt): meshopt's 0.2 bytes more a point ";
  EXPECT_THAT(Latticectl(AtServer({"watch", "scene-one", "--updates", "1"})).err,
              ContainsRegex(kChosen));
  EXPECT_EQ(Latticectl(AtServer({"watch", "scene-one", "--updates", "1", "--encoding", "raw"})).err,
            "");
  ExpectFailure({"watch", "scene-one", "--updates", "1", "--max-bytes-per-second", "1000000",
                 "--drag-position-bits", "8", "--drag-normal-bits", "6", "--max-points", "1"},
                HasSubstr("--max-points: got 1"));
}

TEST_F(LatticectlServerTest, ExportsEveryFormat) {
  MakeScene();
  for (const char* name : {"o.ply", "o.obj", "o.stl", "o.glb", "o.drc"}) {
    Run({"export", "scene-one", "-o", Path(name)});
    const auto file = ReadMeshFile(Path(name));
    ASSERT_OK(file);
    EXPECT_OK(ParseMesh(*file)) << name;
  }
  Run({"export", "scene-one", "-o", Path("o.nets")});
  const auto nets = ReadFile(Path("o.nets"));
  ASSERT_OK(nets);
  EXPECT_EQ(nets->substr(0, 8), "LATTNETS");
  Run({"export", "scene-one", "-o", Path("o.usda")});
  const auto usd = ReadFile(Path("o.usda"));
  ASSERT_OK(usd);
  EXPECT_EQ(usd->substr(0, 9), "#usda 1.0");
  ExpectFailure({"upload", Path("o.usda")}, HasSubstr("o.usda: USD is written, but not read"));
}

TEST_F(LatticectlServerTest, ExportsTheOriginalMesh) {
  MakeScene();
  Run({"export", "scene-one", "-o", Path("moved.obj"), "--original"});
  const auto moved = ReadMeshFile(Path("moved.obj")), source = ReadMeshFile(Path("vase.obj"));
  ASSERT_OK(moved);
  ASSERT_OK(source);
  const auto mesh = ParseMesh(*moved), rest = ParseMesh(*source);
  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->corner_vertices, rest->corner_vertices);
  EXPECT_EQ(mesh->face_offsets, rest->face_offsets);
}

TEST_F(LatticectlServerTest, ExportsPatchesApart) {
  MakeScene();
  Run({"export", "scene-one", "-o", Path("apart.ply"), "--patches", "--segments", "3"});
  const auto apart = ReadMeshFile(Path("apart.ply"));
  ASSERT_OK(apart);
  const auto mesh = ParseMesh(*apart);
  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->positions.size(), mesh->face_count() / 9 * 10);
}

TEST_F(LatticectlServerTest, ApplyGivesTheSameAsInItsOwnProcessAndLeavesNothingThere) {
  MustRun({"lattice", Path("vase.obj"), "-o", Path("L.json")});
  const std::vector<std::string> apply{"apply",        Path("vase.obj"), "--lattice",
                                       Path("L.json"), "--segments",     "2"};
  auto here = apply, there = apply;
  here.insert(here.end(), {"-o", Path("here.ply"), "--backend", "cpu"});
  there.insert(there.end(), {"-o", Path("there.ply")});
  MustRun(here);
  Run(there);
  EXPECT_EQ(*ReadFile(Path("here.ply")), *ReadFile(Path("there.ply")));
  EXPECT_EQ(RunJson({"scene", "list"}).size(), 0u);
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);

  // The mesh of a scene that the server refuses is deleted as well.
  ASSERT_OK(WriteFile(Path("L.json"),
                      R"({"frame": {"u": {"x": 1}, "v": {"y": 1}, "w": {"z": 1}},
                          "degree": {"u": 4, "v": 2, "w": 2}, "size": {"u": 5, "v": 4, "w": 4}})"));
  EXPECT_EQ(Latticectl(AtServer(there)).code, 1);
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);
}

TEST_F(LatticectlServerTest, QuickstartWritesRestAndDeformed) {
  const auto report =
      RunJson({"quickstart", "--sample", "beam", "--steps", "3", "--output", Path("q")});
  EXPECT_EQ(report["updates"], 3);
  EXPECT_GT(report["ratioToRaw"], 2.0);
  for (const char* name : {"q/rest.ply", "q/rest.glb", "q/deformed.ply", "q/deformed.glb"}) {
    const auto file = ReadMeshFile(Path(name));
    ASSERT_OK(file);
    EXPECT_OK(ParseMesh(*file)) << name;
  }
  EXPECT_NE(*ReadFile(Path("q/rest.ply")), *ReadFile(Path("q/deformed.ply")));
}

}  // namespace
}  // namespace latticed::client
