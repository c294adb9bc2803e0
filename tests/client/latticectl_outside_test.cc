// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What goes on outside the lattice, on the command line: lattice --box --outside, edit outside, apply --vertices-only.
#include <cmath>
#include <string>
#include <vector>

#include "client/cpp/latticectl/geometry/files.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/geometry/outside_text.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/library/latticed_client.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::HasSubstr;

class LatticectlOutside : public LatticectlServer {
 protected:
  // Around the lower half of the vase, whose z goes from -1 to 1.
  std::vector<std::string> HalfLattice(const std::string& outside) const {
    return {"lattice",   Path("vase.obj"), "--box", "-3,-3,-1.5,3,3,0",
            "--outside", outside,          "-o",    Path("half.json")};
  }
  v1::Lattice LatticeOf(const std::string& scene) {
    const auto state = Client::Connect({.address = address()})->GetLattice(scene);
    EXPECT_OK(state);
    return state.ok() ? state->lattice() : v1::Lattice();
  }
  v1::LatticeOutside OutsideOf(const std::string& scene) { return LatticeOf(scene).outside(); }
};

TEST_F(LatticectlOutside, ALatticeAroundAPartGoesOn) {
  MustRun(HalfLattice("falloff:0,0,0,0,0,0.5:c0"));
  const auto lattice = ReadLattice(Path("half.json"));
  ASSERT_OK(lattice);
  EXPECT_EQ(lattice->frame().origin().z(), -1.5);
  EXPECT_EQ(lattice->frame().w().z(), 1.5);
  EXPECT_EQ(lattice->outside().mode(), v1::OUTSIDE_MODE_FALLOFF);
  EXPECT_EQ(lattice->outside().continuity(), v1::OUTSIDE_CONTINUITY_C0);
  EXPECT_EQ(lattice->outside().widths(5), 0.5);
  EXPECT_THAT(Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--lattice",
                   Path("half.json")}),
              HasSubstr("falloff outside of widths 0,0,0,0,0,0.5"));
  EXPECT_EQ(OutsideOf("scene-one").steps_size(), 6);
}

TEST_F(LatticectlOutside, VerticesFollowIt) {
  MustRun(HalfLattice("linear"));
  auto lattice = ReadLattice(Path("half.json"));
  ASSERT_OK(lattice);
  // A shear of x by z, which goes on as it is.
  for (int n = 0; n + 2 < lattice->control_points_size(); n += 3) {
    lattice->set_control_points(n,
                                lattice->control_points(n) + 0.5 * lattice->control_points(n + 2));
  }
  ASSERT_OK(WriteFile(Path("half.json"), MessageJson(*lattice)));
  MustRun({"apply", Path("vase.obj"), "--lattice", Path("half.json"), "-o", Path("out.obj"),
           "--vertices-only"});
  const auto before = ParseMesh(*ReadMeshFile(Path("vase.obj")));
  const auto after = ParseMesh(*ReadMeshFile(Path("out.obj")));
  ASSERT_OK(after);
  ASSERT_EQ(after->positions.size(), before->positions.size());
  double highest = 0;
  for (size_t n = 0; n < after->positions.size(); ++n) {
    const Vec3d p = before->positions[n], q = after->positions[n];
    EXPECT_LE(std::abs(q.x - (p.x + 0.5 * p.z)), 1e-5 * (1 + std::abs(p.x)));
    highest = std::max(highest, p.z);
  }
  EXPECT_GT(highest, 0.5) << "nothing of the mesh is outside";
}

TEST_F(LatticectlOutside, ASceneIsGivenAnother) {
  MustRun(HalfLattice("fixed"));
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--lattice", Path("half.json")});
  Run({"edit", "move", "scene-one", "--point", "1,1,3", "--by", "0,0,0.25"});
  const v1::Lattice before = LatticeOf("scene-one");
  EXPECT_FALSE(before.has_outside());
  Run({"edit", "outside", "scene-one", "falloff:0.3"});
  const v1::Lattice after = LatticeOf("scene-one");
  EXPECT_EQ(OutsideOf("scene-one").widths_size(), 6);
  EXPECT_TRUE(std::equal(before.control_points().begin(), before.control_points().end(),
                         after.control_points().begin()));
  Run({"edit", "outside", "scene-one", "linear:2"});
  EXPECT_EQ(OutsideOf("scene-one").mode(), v1::OUTSIDE_MODE_LINEAR);
  Run({"edit", "outside", "scene-one", "fixed"});
  EXPECT_EQ(OutsideOf("scene-one").mode(), v1::OUTSIDE_MODE_UNSPECIFIED);
}

TEST_F(LatticectlOutside, ASceneHasSeveralLattices) {
  MustRun(HalfLattice("falloff:0,0,0,0,0,0.5"));
  MustRun({"lattice", Path("vase.obj"), "-o", Path("whole.json")});
  EXPECT_THAT(Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--lattice",
                   Path("whole.json"), "--lattice", Path("half.json")}),
              HasSubstr("falloff outside of widths 0,0,0,0,0,0.5"));
  EXPECT_THAT(Run({"edit", "move", "scene-one", "--lattice-number", "1", "--point", "1,1,3", "--by",
                   "0,0,0.25"}),
              HasSubstr("revision 1"));
  const auto client = Client::Connect({.address = address()});
  const auto first = client->GetLattice("scene-one"), second = client->GetLattice("scene-one", 1);
  ASSERT_OK(second);
  EXPECT_EQ(second->index(), 1u);
  EXPECT_EQ(second->lattice().frame().origin().z(), -1.5);
  ExpectFailure({"edit", "undo", "scene-one", "--scope", "mine"},
                HasSubstr("lattice 0 has no step of this editor left to undo"));
  EXPECT_THAT(Run({"edit", "undo", "scene-one", "--lattice-number", "1"}), HasSubstr("revision 2"));
  ExpectFailure({"edit", "undo", "scene-one", "--lattice-number", "2"},
                HasSubstr("lattice: got 2"));
}

TEST_F(LatticectlOutside, ALatticeIsAdded) {
  std::vector<std::string> half = HalfLattice("falloff:0,0,0,0,0,0.5");
  half.insert(half.end(), {"--size", "3,4,4"});
  MustRun(half);
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-one"});
  EXPECT_THAT(Run({"edit", "replace", "scene-one", "--add", "--lattice", Path("half.json")}),
              HasSubstr("revision 1"));
  EXPECT_EQ(Client::Connect({.address = address()})->GetScene("scene-one")->lattices_size(), 2);
  EXPECT_EQ(RunJson({"measure", "scene-one", "--area", "--gradient", "--lattice-number",
                     "1"})["areaGradient"]
                .size(),
            3u * 48);
  EXPECT_THAT(Run({"edit", "undo", "scene-one", "--lattice-number", "1"}), HasSubstr("revision 2"));
  EXPECT_EQ(Client::Connect({.address = address()})->GetScene("scene-one")->lattices_size(), 1);
  EXPECT_EQ(Latticectl(AtServer({"edit", "replace", "scene-one", "--add", "--keep-shape",
                                 "--lattice", Path("half.json")}))
                .code,
            2);
}

TEST_F(LatticectlOutside, ALatticeIsRemovedAndGivenBack) {
  std::vector<std::string> half = HalfLattice("falloff:0,0,0,0,0,0.5");
  MustRun(half);
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-one"});
  const auto add = [this] {
    return Run({"edit", "replace", "scene-one", "--add", "--lattice", Path("half.json")});
  };
  add();
  const auto numbers = [this] {
    std::vector<uint32_t> numbers;
    const auto scene = Client::Connect({.address = address()})->GetScene("scene-one");
    for (const auto& lattice : scene->lattices()) numbers.push_back(lattice.index());
    return numbers;
  };

  EXPECT_THAT(Run({"edit", "remove-lattice", "scene-one", "--lattice-number", "0"}),
              HasSubstr("revision 2"));

  EXPECT_EQ(numbers(), std::vector<uint32_t>{1});
  ExpectFailure({"edit", "remove-lattice", "scene-one", "--lattice-number", "1"},
                HasSubstr("a scene's last one cannot go"));
  ExpectFailure({"edit", "reset", "scene-one"}, HasSubstr("lattice 0 was removed"));
  ExpectFailure({"edit", "move", "scene-one", "--point", "0,0,0", "--by", "0,0,1"},
                HasSubstr("lattice 0 was removed"));
  Run({"edit", "undo", "scene-one"});
  EXPECT_EQ(numbers(), (std::vector<uint32_t>{0, 1}));
  EXPECT_THAT(Run({"scene", "show", "scene-one"}), HasSubstr("lattice 1"));
  Run({"edit", "redo", "scene-one"});
  EXPECT_EQ(numbers(), std::vector<uint32_t>{1});
  add();
  EXPECT_EQ(numbers(), (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(Latticectl(AtServer({"edit", "remove-lattice", "scene-one"})).code, 2);
}

TEST_F(LatticectlOutside, ASceneHasAStrength) {
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--strength", "0.5"});
  EXPECT_THAT(Run({"scene", "show", "scene-one"}), HasSubstr("0.5"));
  EXPECT_THAT(Run({"edit", "strength", "scene-one", "0.25"}), HasSubstr("revision 1"));
  EXPECT_EQ(Client::Connect({.address = address()})->GetScene("scene-one")->strength(), 0.25);
  ExpectFailure({"edit", "strength", "scene-one", "1.5"}, HasSubstr("strength"));
  ExpectFailure({"scene", "create", Path("vase.obj"), "--strength", "-1"}, HasSubstr("--strength"));
}

TEST_F(LatticectlOutside, ASceneIsGivenWeights) {
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-one"});
  const auto vertices = ParseMesh(*ReadMeshFile(Path("vase.obj")))->positions.size();
  std::string half = "weight\n";
  for (size_t v = 0; v < vertices; ++v) half += "0.5\n";
  ASSERT_OK(WriteFile(Path("half.csv"), half));
  Run({"edit", "weights", "scene-one", Path("half.csv")});
  EXPECT_THAT(Run({"scene", "show", "scene-one"}), HasSubstr("weights"));
  Run({"edit", "weights", "scene-one", "none"});
  EXPECT_FALSE(Client::Connect({.address = address()})->GetScene("scene-one")->weighted());
  ASSERT_OK(WriteFile(Path("few.csv"), "weight\n0.5\n"));
  ExpectFailure({"edit", "weights", "scene-one", Path("few.csv")}, HasSubstr("weights"));
  ExpectFailure({"edit", "weights", "scene-one", Path("absent.csv")}, HasSubstr("absent.csv"));
}

TEST_F(LatticectlOutside, ALatticeThatTheServerFitsGoesOn) {
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--outside", "falloff:0.3"});
  EXPECT_EQ(OutsideOf("scene-one").mode(), v1::OUTSIDE_MODE_FALLOFF);
  EXPECT_EQ(OutsideOf("scene-one").widths_size(), 6);
  MustRun(HalfLattice("fixed"));
  EXPECT_NE(Latticectl({"scene", "create", Path("vase.obj"), "--lattice", Path("half.json"),
                        "--outside", "linear:1"})
                .code,
            0);
}

TEST_F(LatticectlOutside, BadOnesAreRefused) {
  for (const char* text : {"round", "falloff", "falloff:x", "falloff:1,2", "falloff:0.3:c2",
                           "linear:1,2", "fixed:1", "linear:1:c0"}) {
    SCOPED_TRACE(text);
    EXPECT_THAT(CheckOutside(text), HasSubstr("is not fixed, linear"));
    EXPECT_NE(Latticectl(HalfLattice(text)).code, 0);
  }
  // What the text alone does not show.
  EXPECT_THAT(Latticectl(HalfLattice("falloff:-1")).err, HasSubstr("--outside"));
  auto flat = HalfLattice("fixed");
  flat[3] = "-3,-3,-1.5,3,3,-1.5";
  EXPECT_THAT(Latticectl(flat).err, HasSubstr("--box"));
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-one"});
  ExpectFailure({"edit", "outside", "scene-one", "falloff:5000"}, HasSubstr("outside"));
}

}  // namespace
}  // namespace latticed::client
