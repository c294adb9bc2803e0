// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds on the command line: scene create --fold-watch, edit --refuse-folds, folds and its exit code.
#include <string>
#include <vector>

#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int kFolds = 3;

class LatticectlFolds : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--fold-watch"});
  }
  // Turns the lattice inside out at a corner of the vase's cage, or back.
  std::vector<std::string> Push(const char* by) const {
    return {"edit", "move", "scene-one", "--point", "1,1,1", "--point", "1,2,1", "--by", by};
  }
  RunResult Folds(const char* scope = "surface") const {
    return Latticectl(AtServer({"folds", "scene-one", "--scope", scope}));
  }
};

TEST_F(LatticectlFolds, ASceneAtRestHasNone) {
  for (const char* scope : {"surface", "volume"}) {
    const RunResult result = Folds(scope);
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.out, "no fold in 8 knot boxes\n");
  }
  EXPECT_THAT(Run({"scene", "show", "scene-one"}), HasSubstr("reported with every edit"));
}

TEST_F(LatticectlFolds, AFoldedSceneSaysWhereAndExitsWithThree) {
  EXPECT_THAT(Run(Push("20,0,0")), ContainsRegex("folded: [0-9] of 8 knot boxes\n"));

  const RunResult result = Folds();

  EXPECT_EQ(result.code, kFolds);
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, AllOf(StartsWith("folded: "), HasSubstr("BOX"), HasSubstr("folded  ")));
}

TEST_F(LatticectlFolds, JsonHasTheReport) {
  Run(Push("20,0,0"));
  const RunResult result = Latticectl(AtServer({"folds", "scene-one", "--json"}));
  EXPECT_EQ(result.code, kFolds);
  const auto report = nlohmann::json::parse(result.out, nullptr, false);
  EXPECT_FALSE(report.value("certified", false));
  ASSERT_FALSE(report["places"].empty());
  EXPECT_EQ(report["places"][0]["state"], "FOLD_STATE_FOLDED");
  EXPECT_LE(report["places"][0].value("determinant", 0.0), 0);
}

TEST_F(LatticectlFolds, RefuseFoldsFailsWhereANewFoldWouldBe) {
  auto push = Push("20,0,0");
  push.push_back("--refuse-folds");
  ExpectFailure(push, AllOf(ContainsRegex("the edit makes a fold in knot box [(][0-9, ]*[)], at [(]"
                                          "[-+.e0-9]+, [-+.e0-9]+, [-+.e0-9]+[)]: det J is -"),
                            HasSubstr("; change less, or allow folds")));
  push[8] = "0.01,0,0";
  EXPECT_THAT(Run(push), HasSubstr("no fold in 8 knot boxes\n"));
}

TEST_F(LatticectlFolds, AnUnknownSceneIsAFailure) {
  ExpectFailure({"folds", "scene-two"}, HasSubstr("scene-two"));
}

}  // namespace
}  // namespace latticed::client
