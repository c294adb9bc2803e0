// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl backup and restore: files, what is refused before anything is sent, and what is printed.
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class LatticectlBackup : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    const std::string mesh = RunJson({"upload", Path("vase.obj")})["id"];
    Run({"scene", "create", mesh, "--id", "vase"});
    Run({"edit", "move", "vase", "--point", "1,1,3", "--by", "0", "0", "0.5"});
    file_ = Path("server.backup");
    Run({"backup", file_});
  }
  std::string Bytes() const {
    std::ostringstream bytes;
    bytes << std::ifstream(file_, std::ios::binary).rdbuf();
    return bytes.str();
  }
  // A server with nothing in it takes the file.
  RunResult RestoreElsewhere(std::vector<std::string> more = {}) const {
    const auto other = StartServer();
    std::vector<std::string> arguments{"restore", file_, "--server", other->address()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Latticectl(arguments);
  }

  std::string file_;
};

TEST_F(LatticectlBackup, AFileMakesTheSameOnAnotherServer) {
  const auto other = StartServer();
  EXPECT_FALSE(std::filesystem::exists(file_ + ".part"));

  EXPECT_EQ(MustRun({"restore", file_, "--server", other->address()}),
            "restored 1 mesh and 1 scene\n");

  const auto show = [&](const std::string& server) {
    return nlohmann::json::parse(MustRun({"scene", "show", "vase", "--json", "--server", server}));
  };
  EXPECT_EQ(show(address())["lattices"], show(other->address())["lattices"]);
  EXPECT_EQ(show(other->address())["revision"], "1");
  EXPECT_EQ(MustRun({"restore", file_, "--skip-existing", "--server", other->address()}),
            "restored 0 meshes and 0 scenes; 1 mesh and 1 scene were there\n");
}

TEST_F(LatticectlBackup, SaysWhatTheFileHas) {
  EXPECT_THAT(Run({"backup", file_}), HasSubstr("server.backup: 1 mesh, 1 scene, "));
  const nlohmann::json json = RunJson({"backup", file_, "--scene", "vase"});
  EXPECT_EQ(json["scenes"], 1);
  EXPECT_EQ(json["bytes"], std::filesystem::file_size(file_));
}

TEST_F(LatticectlBackup, AnExistingSceneEndsARestore) {
  ExpectFailure({"restore", file_}, AllOf(HasSubstr("'vase'"), HasSubstr("--skip-existing")));
}

TEST_F(LatticectlBackup, AFailureLeavesTheFileThatWasThere) {
  const std::string before = Bytes();
  ExpectFailure({"backup", file_, "--scene", "no-such-scene"}, HasSubstr("no-such-scene"));
  EXPECT_EQ(Bytes(), before);
  EXPECT_FALSE(std::filesystem::exists(file_ + ".part"));
  ExpectFailure({"backup", Path("no/folder/file")}, HasSubstr("cannot write"));
  ExpectFailure({"restore", Path("no-file")}, HasSubstr("cannot read"));
}

TEST_F(LatticectlBackup, AnyChangeOfTheFileIsRefusedBeforeItIsSent) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const std::string whole = Bytes();
  const auto expect_refused = [&](const std::string& bytes, const std::string& why) {
    std::ofstream(file_, std::ios::binary) << bytes;
    const RunResult result = Latticectl({"restore", file_, "--server", address()});
    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, AllOf(HasSubstr(why), HasSubstr("nothing was sent")));
  };
  for (int n = 0; n < 200; ++n) {
    std::string flipped = whole;
    flipped[random() % whole.size()] ^= static_cast<char>(1 << random() % 8);
    expect_refused(flipped, "server.backup: ");
    expect_refused(whole.substr(0, random() % whole.size()), "server.backup: ");
  }
  expect_refused("", "is no backup");
  expect_refused(whole.substr(0, whole.size() - 1), "is cut off");
  expect_refused(whole + "x", "after its end");
  std::string newer = whole;
  newer[16] = '2';
  expect_refused(newer, "another version");
  std::ofstream(file_, std::ios::binary) << whole;
  EXPECT_EQ(RestoreElsewhere().code, 0);
}

}  // namespace
}  // namespace latticed::client
