// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes of several lattices, and what edits of each keep, on the command line: whose step undo reverts, turned lattices,
// constraints and held points, --keep-volume.
#include <cmath>
#include <string>
#include <vector>

#include "client/cpp/latticectl/geometry/files.h"
#include "client/cpp/library/latticed_client.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class LatticectlLattices : public LatticectlServer {
 protected:
  static constexpr char kId[] = "scene-one";

  void MakeScene() { Run({"scene", "create", Path("vase.obj"), "--id", kId}); }
  // Adds lattice 1, around a part of the vase.
  std::string Add(const std::vector<std::string>& options = {}) {
    std::vector<std::string> lattice{
        "lattice",   Path("vase.obj"), "--box", "-0.5,-0.5,0,0.5,0.5,0.7",
        "--outside", "falloff:0.5",    "-o",    Path("part.json")};
    lattice.insert(lattice.end(), options.begin(), options.end());
    MustRun(lattice);
    return Run({"edit", "replace", kId, "--add", "--lattice", Path("part.json")});
  }
  std::string Move(const std::string& number, const std::vector<std::string>& more = {}) {
    std::vector<std::string> line{"edit",    "move",  kId,    "--lattice-number", number,
                                  "--point", "1,1,2", "--by", "0,0,0.125"};
    line.insert(line.end(), more.begin(), more.end());
    return Run(line);
  }
  double Volume() { return RunJson({"measure", kId, "--volume"})["volume"].get<double>(); }
};

TEST_F(LatticectlLattices, UndoNamesTheLatticeWhoseStepsItMeans) {
  MakeScene();
  EXPECT_THAT(Add(),
              HasSubstr("it is lattice 1: edits, undo too, name it by --lattice-number 1\n"));
  Move("1");
  const auto refused = [](const std::string& what) {
    return AllOf(HasSubstr("latticectl: lattice 0 has no " + what),
                 HasSubstr("; other lattices, also removed ones, have steps of their own: "
                           "--lattice-number (NOTHING_TO_"));
  };
  ExpectFailure({"edit", "undo", kId}, refused("step left to undo;"));
  ExpectFailure({"edit", "undo", kId, "--scope", "mine"},
                refused("step of this editor left to undo;"));
  ExpectFailure({"edit", "redo", kId}, refused("step left that this editor has undone;"));
  Move("0");
  Move("1");
  Run({"edit", "undo", kId});  // lattice 0's, though lattice 1 had the last edit
  ExpectFailure({"edit", "undo", kId}, refused("step left to undo;"));
  EXPECT_THAT(MustRun({"edit", "undo", "--help"}), HasSubstr("of one lattice"));
}

TEST_F(LatticectlLattices, RemovalSaysHowTheLatticeComesBack) {
  MakeScene();
  Add();
  const std::string removed = Run({"edit", "remove-lattice", kId, "--lattice-number", "1"});
  EXPECT_THAT(removed,
              HasSubstr("'latticectl edit undo scene-one --lattice-number 1' gives it back\n"));
  ExpectFailure({"edit", "undo", kId}, HasSubstr("lattice 0 has no step left to undo"));
  Run({"edit", "undo", kId, "--lattice-number", "1"});
  EXPECT_EQ(Client::Connect({.address = address()})->GetScene(kId)->lattices_size(), 2);
  EXPECT_THAT(MustRun({"edit", "remove-lattice", "--help"}),
              HasSubstr("undo with the same --lattice-number gives it back"));
}

TEST_F(LatticectlLattices, ATurnedLatticeIsAddedAndShown) {
  MakeScene();
  Add({"--turn", "0,30,0"});
  EXPECT_THAT(Run({"scene", "show", kId}), HasSubstr(", turned against lattice 0\n"));
  EXPECT_THAT(Move("1"), HasSubstr("largest move 0.125"));
  Run({"export", kId, "-o", Path("turned.ply")});
}

TEST_F(LatticectlLattices, WatchSaysWhyTurnedOnesHaveNoPatches) {
  MakeScene();
  Add({"--turn", "0,30,0"});
  const auto watch = [](const std::string& encoding) {
    return std::vector<std::string>{"watch", kId, "--updates", "1", "--encoding", encoding};
  };
  ExpectFailure(
      watch("patches"),
      HasSubstr("--encoding: no patches here: the scene's lattices are turned against each other"));
  EXPECT_THAT(Run(watch("raw")), HasSubstr("revision 1"));

  Run({"scene", "create", Path("vase.obj"), "--id", "by-gemm", "--pipeline", "gemm"});
  ExpectFailure({"watch", "by-gemm", "--updates", "1", "--encoding", "patches"},
                HasSubstr("--encoding: no patches here"));
}

TEST_F(LatticectlLattices, ShowHasALineForEachConstraint) {
  MakeScene();
  EXPECT_THAT(Run({"scene", "show", kId}),
              AllOf(Not(HasSubstr("held")), Not(HasSubstr("mirror")), Not(HasSubstr("kept"))));
  EXPECT_FALSE(RunJson({"scene", "show", kId})["lattices"][0].contains("constraints"));

  Run({"edit", "constrain", kId, "--point", "1,2,3", "--point", "0,0,0", "--layers", "w-1",
       "--layers", "v+2", "--mirror", "u", "--keep-volume", "--volume-axis", "w"});
  Run({"edit", "strength", kId, "0.5"});

  const std::string text = Run({"scene", "show", kId});
  EXPECT_THAT(text, ::testing::ContainsRegex("\nheld points +1,2,3 0,0,0\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nheld layers +w-1 v\\+2\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nmirror +on u\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex(
                        "\nkept volume +that of the mesh at rest, by moves along w\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nstrength +0.5\n"));
  const nlohmann::json lattice = RunJson({"scene", "show", kId})["lattices"][0];
  EXPECT_EQ(lattice["strength"], 0.5);
  EXPECT_EQ(lattice["constraints"]["held"], (std::vector<int>{57, 0}));
  EXPECT_EQ(lattice["constraints"]["heldLayers"][1]["layers"], 2);
  EXPECT_EQ(lattice["constraints"]["mirror"], "LATTICE_AXIS_U");
  EXPECT_EQ(lattice["constraints"]["volume"]["axis"], "LATTICE_AXIS_W");
}

TEST_F(LatticectlLattices, ShowSaysWhichLatticeKeepsWhat) {
  MakeScene();
  Add();
  std::vector<std::string> many{"edit", "constrain", kId, "--lattice-number", "1", "--volume", "2"};
  for (const char* k : {"0", "1", "2"}) {
    for (const char* j : {"0", "1", "2"}) {
      many.insert(many.end(), {"--point", std::string("1,") + j + "," + k});
    }
  }
  Run({"edit", "strength", kId, "0.25", "--lattice-number", "1"});
  Run(many);
  const std::string text = Run({"scene", "show", kId});
  EXPECT_THAT(text, ::testing::ContainsRegex("\nheld points of 1 +1,0,0 .* 1,1,2 and 1 more\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nkept volume of 1 +2\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nstrength of 1 +0.25\n"));
  EXPECT_THAT(text, Not(HasSubstr(" of 0 ")));
  const nlohmann::json lattices = RunJson({"scene", "show", kId})["lattices"];
  EXPECT_FALSE(lattices[0].contains("constraints"));
  EXPECT_EQ(lattices[1]["constraints"]["volume"]["volume"], 2);
}

TEST_F(LatticectlLattices, EditsSayWhichPointsAreHeld) {
  MakeScene();
  Run({"edit", "constrain", kId, "--point", "1,1,2", "--layers", "w-1", "--mirror", "u"});
  EXPECT_THAT(Move("0"),
              HasSubstr("largest move 0\n1 of 1 control points is held and did not move"));
  const auto move = [this](const std::string& point) {
    return Run({"edit", "move", kId, "--point", "1,1,2", "--point", "3,2,0", "--point", point,
                "--by", "0,0,0.125"});
  };
  EXPECT_THAT(move("2,1,2"), HasSubstr("3 of 3 control points are held")) << "an image";
  EXPECT_THAT(move("1,2,1"), HasSubstr("2 of 3 control points are held"));
  EXPECT_THAT(Run({"edit", "set", kId, "--point", "0,0,0", "--to", "0,0,0"}),
              HasSubstr("1 of 1 control points is held"));
  EXPECT_THAT(Run({"edit", "reset", kId}), HasSubstr("18 of 64 control points are held"));
  EXPECT_THAT(Run({"edit", "move", kId, "--point", "1,2,1", "--by", "0,0,0.125"}),
              Not(HasSubstr("held")));
}

TEST_F(LatticectlLattices, AnEditKeepsTheVolumeOnItsOwn) {
  MustRun({"sample", "gear", "-o", Path("gear.obj")});
  Run({"scene", "create", Path("gear.obj"), "--id", kId});
  const double rest = Volume();
  Move("0", {"--keep-volume"});
  EXPECT_NEAR(Volume(), rest, 1e-11 * std::abs(rest));
  Run({"edit", "set", kId, "--point", "1,1,1", "--to", "0,0,0.3", "--keep-volume"});
  EXPECT_NEAR(Volume(), rest, 1e-11 * std::abs(rest));
  Move("0");
  EXPECT_GT(std::abs(Volume() - rest), 1e-6 * std::abs(rest)) << "kept by nobody";
  Run({"edit", "strength", kId, "0.5", "--keep-volume"});
  EXPECT_NEAR(Volume(), rest, 1e-11 * std::abs(rest));
  EXPECT_THAT(Run({"scene", "show", kId}), Not(HasSubstr("kept volume")));
  EXPECT_EQ(Latticectl(AtServer({"edit", "undo", kId, "--keep-volume"})).code, 2);
}

// A square, which encloses nothing.
constexpr char kSquare[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

TEST_F(LatticectlLattices, MeasureSaysWhatAnOpenMeshHas) {
  ASSERT_OK(WriteFile(Path("square.obj"), kSquare));
  Run({"scene", "create", Path("square.obj"), "--id", kId});
  ExpectFailure(
      {"measure", kId},
      HasSubstr("; 'measure --area --bounds' works on open and torn surfaces (OPEN_SURFACE"));
  EXPECT_THAT(Run({"measure", kId, "--area", "--bounds"}), HasSubstr("area     1, within"));
  ExpectFailure({"edit", "move", kId, "--point", "1,1,1", "--by", "0,0,1", "--keep-volume"},
                HasSubstr("encloses no volume"));
}

TEST_F(LatticectlLattices, WeightsOfTheMeshAreTakenAtCreation) {
  MakeScene();
  ExpectFailure({"edit", "weights", kId, "attribute"},
                AllOf(HasSubstr("'scene create --weights attribute'"),
                      HasSubstr("name a .npy or .csv file, or none")));
}

TEST_F(LatticectlLattices, HelpNamesAllThatGoesOnOutside) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"lattice"}, {"scene", "create"}, {"edit", "outside"}}) {
    std::vector<std::string> line = command;
    line.push_back("--help");
    const std::string help = MustRun(line);
    for (const char* text : {"linear:WIDTH", "falloff:WIDTH:c0", "falloff:0,0,0,0,0,0.5"}) {
      EXPECT_THAT(help, HasSubstr(text));
    }
  }
}

}  // namespace
}  // namespace latticed::client
