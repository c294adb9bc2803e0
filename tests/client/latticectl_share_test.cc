// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl share: makes, lists and revokes; and a share's token is all that a guest's commands need.
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class LatticectlShare : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    Run({"scene", "create", Path("vase.obj"), "--id", "vase"});
    Run({"scene", "create", Path("vase.obj"), "--id", "other"});
  }
  RunResult AsGuest(std::vector<std::string> arguments, const std::string& token) const {
    arguments.insert(arguments.end(), {"--token", token});
    return Latticectl(AtServer(std::move(arguments)));
  }
};

TEST_F(LatticectlShare, AGuestHasOneScene) {
  const nlohmann::json made = RunJson({"share", "create", "vase", "--role", "edit"});
  const std::string token = made["token"];

  EXPECT_EQ(
      AsGuest({"edit", "move", "vase", "--point", "1,1,3", "--by", "0", "0", "0.5"}, token).code,
      0);
  EXPECT_EQ(AsGuest({"export", "vase", "-o", Path("vase.ply")}, token).code, 0);
  EXPECT_THAT(AsGuest({"scene", "show", "other"}, token).err, HasSubstr("'other'"));
  EXPECT_THAT(AsGuest({"scene", "list"}, token).err, HasSubstr("one scene alone"));

  EXPECT_EQ(Run({"share", "revoke", "vase", made["share"]["shareId"]}),
            "share " + std::string(made["share"]["shareId"]) + " is revoked\n");
  EXPECT_THAT(AsGuest({"scene", "show", "vase"}, token).err, HasSubstr("revoked"));
}

TEST_F(LatticectlShare, SaysTheLinkOfTheViewer) {
  const std::string text =
      Run({"share", "create", "vase", "--ttl", "90m", "--viewer", "https://studio/"});
  EXPECT_THAT(text, AllOf(HasSubstr("may    read"), HasSubstr("token  share-"),
                          HasSubstr("link   https://studio/?scene=vase#token=share-")));
  EXPECT_THAT(Run({"share", "create", "vase"}), Not(HasSubstr("link")));
}

TEST_F(LatticectlShare, ListsWithoutTokens) {
  const nlohmann::json made = RunJson({"share", "create", "vase", "--ttl", "30d"});
  const std::string text = Run({"share", "list", "vase"});
  EXPECT_THAT(text, AllOf(HasSubstr("SHARE"), HasSubstr(std::string(made["share"]["shareId"])),
                          Not(HasSubstr("share-"))));
  EXPECT_EQ(RunJson({"share", "list", "vase"}).size(), 1U);
  EXPECT_EQ(RunJson({"share", "list", "other"}).size(), 0U);
}

TEST_F(LatticectlShare, SaysWhatIsWrong) {
  ExpectFailure({"share", "create", "no-such-scene"}, HasSubstr("no-such-scene"));
  for (const char* ttl : {"0s", "367d"}) {
    ExpectFailure({"share", "create", "vase", "--ttl", ttl}, HasSubstr("ttl"));
  }
  ExpectFailure({"share", "revoke", "vase", "no-such-share"}, HasSubstr("no-such-share"));
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"--ttl", "90"}, {"--ttl", "90x"}, {"--role", "admin"}}) {
    std::vector<std::string> arguments{"share", "create", "vase"};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    EXPECT_EQ(Latticectl(AtServer(arguments)).code, 2) << wrong[1];
  }
}

}  // namespace
}  // namespace latticed::client
