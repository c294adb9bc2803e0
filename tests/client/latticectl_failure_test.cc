// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What latticectl prints when a command fails: one line, for people or as JSON.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "absl/time/clock.h"
#include "client/cpp/latticectl/command_line/failure.h"
#include "core/base/error.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class LatticectlFailure : public LatticectlTest {
 protected:
  static std::string Error(const std::vector<std::string>& arguments, int code) {
    const RunResult result = Latticectl(arguments);
    EXPECT_EQ(result.code, code);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    return result.err;
  }

  static nlohmann::json JsonError(std::vector<std::string> arguments, int code) {
    arguments.push_back("--json");
    const auto json = nlohmann::json::parse(Error(arguments, code), nullptr, false);
    EXPECT_EQ(json.size(), 1u);
    return json["error"];
  }
};

TEST_F(LatticectlFailure, NamesTheCommandThatWasMeant) {
  EXPECT_EQ(Error({"aply"}, 2), "latticectl: unknown command 'aply'; did you mean 'apply'?\n");
  EXPECT_EQ(Error({"aply", "a.obj", "-o", "b.ply"}, 2),
            "latticectl: unknown command 'aply'; did you mean 'apply'?\n");
  EXPECT_EQ(Error({"quick"}, 2),
            "latticectl: unknown command 'quick'; did you mean 'quickstart'?\n");
  EXPECT_EQ(Error({"scene", "creat", "a.obj"}, 2),
            "latticectl: unknown command 'scene creat'; did you mean 'scene create'?\n");
  EXPECT_EQ(
      Error({"edit", "fly"}, 2),
      "latticectl: unknown command 'edit fly'; 'latticectl edit --help' shows the commands\n");
}

TEST_F(LatticectlFailure, NamesTheOptionThatWasMeant) {
  EXPECT_EQ(Error({"--versoin"}, 2),
            "latticectl: unknown option '--versoin'; did you mean '--version'?\n");
  // The required option is missing as well.
  EXPECT_EQ(Error({"apply", "a.obj", "--latice", "L.json", "-o", "b.ply"}, 2),
            "latticectl: unknown option '--latice'; did you mean '--lattice'?\n");
  EXPECT_EQ(Error({"scene", "create", "a.obj", "--seg=3"}, 2),
            "latticectl: unknown option '--seg'; did you mean '--segments'?\n");
  // An option of a group.
  EXPECT_EQ(
      Error({"edit", "drag", "my-scene", "--rya", "0,0,0,1,0,0", "--by", "1,0,0"}, 2),
      "latticectl: unknown option '--rya'; 'latticectl edit drag --help' shows the options\n");
  EXPECT_EQ(Error({"edit", "drag", "my-scene", "--rays", "0,0,0,1,0,0", "--by", "1,0,0"}, 2),
            "latticectl: unknown option '--rays'; did you mean '--ray'?\n");
  EXPECT_EQ(Error({"bench", "--editor", "2"}, 2),
            "latticectl: unknown option '--editor'; did you mean '--editors'?\n");
  EXPECT_EQ(Error({"info", "--frobnicate"}, 2),
            "latticectl: unknown option '--frobnicate'; 'latticectl info --help' shows the "
            "options\n");
}

TEST_F(LatticectlFailure, TakesNoNumberForAnOption) {
  EXPECT_THAT(Error({"edit", "insert-knot", "my-scene", "u", "0.5", "-3"}, 2),
              AllOf(HasSubstr("not expected: -3"), Not(HasSubstr("option"))));
  EXPECT_THAT(Error({"edit", "move", "my-scene", "--point", "1,1,1", "-1,0,0"}, 2),
              HasSubstr("--by is required"));
  EXPECT_THAT(Error({"edit", "-3"}, 2), HasSubstr("unknown command 'edit -3'"));
}

// A script may have an empty variable in the place of the command.
TEST_F(LatticectlFailure, IsJsonWithoutACommand) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{}, {""}, {"scene"}, {"scene", ""}, {"edit"}}) {
    EXPECT_EQ(JsonError(arguments, 2)["code"], "INVALID_ARGUMENT");
  }
}

TEST_F(LatticectlFailure, OfUsageIsJsonToo) {
  const auto unknown = JsonError({"aply"}, 2);
  EXPECT_EQ(unknown, nlohmann::json({{"message", "unknown command 'aply'"},
                                     {"advice", "did you mean 'apply'?"},
                                     {"code", "INVALID_ARGUMENT"}}));
  const auto range = JsonError({"export", "my-scene", "-o", "o.ply", "--segments", "33"}, 2);
  EXPECT_THAT(range["message"], HasSubstr("--segments"));
  EXPECT_EQ(range["advice"], "'latticectl export --help' says more");
}

TEST_F(LatticectlFailure, OfFilesAndConnectionsIsJson) {
  const auto file = JsonError({"lattice", "none.obj"}, 1);
  EXPECT_THAT(file["message"], HasSubstr("none.obj"));
  EXPECT_EQ(file["reason"], "NOT_FOUND");
  EXPECT_EQ(file["code"], "NOT_FOUND");
  EXPECT_FALSE(file.contains("advice"));
  EXPECT_FALSE(file.contains("requestId"));

  const auto closed = JsonError({"info", "--server", "127.0.0.1:1", "--retry-for", "0"}, 1);
  EXPECT_THAT(closed["message"], HasSubstr("refused"));
  EXPECT_THAT(closed["advice"], HasSubstr("'latticed --listen 127.0.0.1:1'"));
  EXPECT_EQ(closed["reason"], "UNAVAILABLE");
  EXPECT_EQ(closed["code"], "UNAVAILABLE");
}

TEST_F(LatticectlFailure, ComesAfterALineThatSaysForHowLongItTries) {
  const RunResult text = Latticectl({"info", "--server", "127.0.0.1:1", "--retry-for", "2"});
  EXPECT_EQ(text.code, 1);
  EXPECT_THAT(text.err, StartsWith("latticectl: server unreachable, trying for 2 s …\n"
                                   "latticectl: "));
  EXPECT_EQ(std::count(text.err.begin(), text.err.end(), '\n'), 2) << text.err;

  const RunResult json =
      Latticectl({"info", "--server", "127.0.0.1:1", "--retry-for", "2", "--json"});
  EXPECT_THAT(json.err, StartsWith("{\"notice\":{\"message\":\"server unreachable, trying for "
                                   "2 s …\"}}\n{\"error\":"));
}

TEST_F(LatticectlFailure, DoesNotComeIfTheServerStartsMeanwhile) {
  Options options = QuietOptions();
  options.listen = "unix:" + Path("server.sock");
  absl::StatusOr<std::unique_ptr<InProcessServer>> server;
  std::thread starter([&] {
    absl::SleepFor(absl::Seconds(2));
    server = InProcessServer::Serve(options);
  });
  const RunResult result = Latticectl({"info", "--server", options.listen});
  starter.join();
  ASSERT_OK(server);
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err,
            "latticectl: server unreachable, trying for 30 s …\n"
            "latticectl: the server answers again\n");
}

TEST_F(LatticectlFailure, InJsonHasNoBytesOutsideOfUtf8) {
  const auto json = JsonError({"lattice", "\xff.obj"}, 1);
  EXPECT_THAT(json["message"], HasSubstr("\xef\xbf\xbd.obj"));
}

TEST_F(LatticectlFailure, SaysWhenAPortSpeaksHttpOrNoTls) {
  Options options = QuietOptions();
  options.http = "127.0.0.1:0";
  const auto server = StartServer(options);
  ASSERT_NE(server, nullptr);
  const std::string http = server->http_address();
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"info"}, {"watch", "my-scene"}}) {
    auto arguments = command;
    arguments.insert(arguments.end(), {"--server", http});
    EXPECT_EQ(Error(arguments, 1), "latticectl: " + http +
                                       " speaks HTTP, not gRPC; give the port of the server's "
                                       "--listen (UNAVAILABLE)\n");
  }
  EXPECT_THAT(Error({"info", "--tls", "--server", server->address()}, 1),
              StartsWith("latticectl: " + server->address() + " does not speak TLS; leave out"));
  ASSERT_OK(WriteFile(Path("empty.pem"), ""));
  EXPECT_THAT(Error({"info", "--tls-ca", Path("empty.pem"), "--server", server->address()}, 1),
              HasSubstr("does not speak TLS"));
}

TEST_F(LatticectlFailure, SpeaksOfTlsFilesOnlyIfTlsWasAskedFor) {
  EXPECT_THAT(Error({"info", "--server", "ipv4:"}, 1),
              AllOf(HasSubstr("empty address list"), Not(HasSubstr("TLS"))));
  ASSERT_OK(WriteFile(Path("bad.pem"), "no certificate"));
  EXPECT_THAT(Error({"info", "--tls-ca", Path("bad.pem"), "--server", "127.0.0.1:1"}, 1),
              StartsWith("latticectl: the TLS files cannot be used; check --tls-ca"));
}

class LatticectlServerFailure : public LatticectlServer {};

TEST_F(LatticectlServerFailure, HasTheReasonAndTheRequestInJson) {
  const RunResult result = Latticectl(AtServer({"scene", "show", "no-scene", "--json"}));
  EXPECT_EQ(result.code, 1);
  const auto error = nlohmann::json::parse(result.err, nullptr, false)["error"];
  EXPECT_THAT(error["message"], HasSubstr("no-scene"));
  EXPECT_EQ(error["advice"], "'latticectl scene list' shows what there is");
  EXPECT_EQ(error["reason"], "NOT_FOUND");
  EXPECT_EQ(error["code"], "NOT_FOUND");
  EXPECT_THAT(error["requestId"], Not(""));
}

TEST(FailureTest, AdviceOfACommandIsPrinted) {
  const absl::Status status = error::WithDetails(
      absl::AbortedError("it broke"),
      {.reason = "STRUCTURE_CHANGED", .metadata = {{kAdviceKey, "mend it"}, {"request_id", "7"}}});
  const CLI::App app;
  std::ostringstream text, json;
  PrintFailure(FailureOf(status, app), /*as_json=*/false, text);
  PrintFailure(FailureOf(status, app), /*as_json=*/true, json);
  EXPECT_EQ(text.str(), "latticectl: it broke; mend it (STRUCTURE_CHANGED, request 7)\n");
  EXPECT_EQ(json.str(), R"({"error":{"advice":"mend it","code":"ABORTED","message":"it broke",)"
                        R"("reason":"STRUCTURE_CHANGED","requestId":"7"}})"
                        "\n");
}

TEST(FailureTest, ARequestIsPrintedWithoutAReasonToo) {
  std::ostringstream text;
  PrintFailure({.message = "it broke", .request_id = "7"}, /*as_json=*/false, text);
  EXPECT_EQ(text.str(), "latticectl: it broke (request 7)\n");
}

}  // namespace
}  // namespace latticed::client
