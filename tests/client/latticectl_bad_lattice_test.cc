// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A bad lattice given to latticectl: exit code 1, one sentence that names the field, no output
// file.
#include <algorithm>
#include <filesystem>

#include "client/cpp/latticectl/lattice_json.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

using ::testing::HasSubstr;

class LatticectlBadLattice : public LatticectlTest {
 protected:
  void SetUp() override {
    LatticectlTest::SetUp();
    ASSERT_OK(WriteFile(Path("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n"));
  }
};

TEST_F(LatticectlBadLattice, ApplySaysInOneSentenceWhatIsWrong) {
  const std::string frame = R"("frame": {"u": {"x": 1}, "v": {"y": 1}, "w": {"z": 1}})";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"{" + frame + R"(, "controlPoints": ["NaN", 0, 0]})", "control_points"},
      {"{" + frame + R"(, "knotsV": [0, 0, 0, 2, 1, 3, 3]})", "knots_v: knots must not decrease"},
      {R"({"frame": {"u": {"x": 1}, "v": {"x": 2}, "w": {"z": 1}}})",
       "frame: the three edge vectors must span a volume"},
      {"{" + frame + R"(, "degree": {"u": 2, "v": 0, "w": 2}})",
       "degree.v: got 0, allowed is 1 to 3"},
      {"{" + frame + R"(, "controlPoints": [0, 0, 0]})", "control_points: got 1 points"},
  };
  for (const auto& [json, text] : cases) {
    SCOPED_TRACE(json);
    ASSERT_OK(WriteFile(Path("L.json"), json));

    const RunResult result = Latticectl({"apply", Path("m.obj"), "--lattice", Path("L.json"),
                                         "--backend", "cpu", "-o", Path("o.ply")});

    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(std::filesystem::exists(Path("o.ply")));
  }
}

TEST_F(LatticectlBadLattice, ApplyTakesTheGoodOneAfterwards) {
  ASSERT_OK(
      WriteFile(Path("L.json"), R"({"frame": {"u": {"x": 1}, "v": {"y": 1}, "w": {"z": 1}}})"));
  MustRun({"apply", Path("m.obj"), "--lattice", Path("L.json"), "--backend", "cpu", "-o",
           Path("o.ply")});
  EXPECT_TRUE(std::filesystem::exists(Path("o.ply")));
}

}  // namespace
}  // namespace latticed::client
