// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The load generator's command against a server in this process. The tests check counts, not durations.
#include <fmt/format.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "client/cpp/load/surface_verifier.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::AnyOf;
using ::testing::HasSubstr;

class LatticectlBench : public LatticectlServer {
 protected:
  // The arguments of a bench of a small vase.
  std::vector<std::string> Vase(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"bench", Path("vase.obj"), "--segments", "2"});
    return flags;
  }
  nlohmann::json Bench(std::vector<std::string> flags) const {
    return RunJson(Vase(std::move(flags)));
  }
};

TEST_F(LatticectlBench, ClosedLoopOfScenesEditorsAndWatchersCountsEveryEdit) {
  const auto result = Bench({"--scenes", "2", "--editors", "2", "--watchers", "3", "--edits", "5"});

  EXPECT_EQ(result["edits"], 2 * 2 * 5);
  EXPECT_EQ(result["editors"]["streams"], 2 * 2);
  EXPECT_EQ(result["watchers"]["streams"], 2 * 3);
  // Every stream shows all 10 edits of its scene.
  for (const char* latency : {"firstChunk", "updateEnd"}) {
    EXPECT_EQ(result["editors"][latency]["count"], 2 * 2 * 10) << latency;
    EXPECT_EQ(result["watchers"][latency]["count"], 2 * 3 * 10) << latency;
  }
  EXPECT_EQ(result["server"]["updatesSuperseded"], 0);
  const auto& end = result["watchers"]["updateEnd"];
  EXPECT_GT(end["p50Ms"], 0.0);
  EXPECT_LE(end["p50Ms"], end["p90Ms"]);
  EXPECT_LE(end["p90Ms"], end["p99Ms"]);
  EXPECT_LE(end["p99Ms"], end["maxMs"]);
  EXPECT_GT(result["editors"]["decoded"]["count"], 0);
  EXPECT_EQ(result["watchers"]["decoded"]["count"], 0);
  EXPECT_GT(result["server"]["encode"]["count"], 0);
  EXPECT_EQ(result["server"]["apply"]["count"], 2 * 2 * 5);
  const auto& to_bytes = result["server"]["arrivalToBytes"];
  EXPECT_EQ(to_bytes["count"], result["server"]["encode"]["count"]) << "once an update";
  EXPECT_GE(to_bytes["maxMs"], result["server"]["queue"]["maxMs"]);
  EXPECT_EQ(result["verified"]["streams"], 2 * (2 + 3));
  EXPECT_GT(result["verified"]["points"], 1000);
  EXPECT_GT(result["verified"]["worst"], 0.1) << "the rounding is there";
  EXPECT_LE(result["verified"]["worst"], 1.0);
  EXPECT_GT(result["cpu"]["client"]["seconds"], 0.0);

  EXPECT_EQ(RunJson({"scene", "list"}).size(), 0u);
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);
}

TEST_F(LatticectlBench, OpenLoopSendsEveryEdit) {
  const auto result =
      Bench({"--rate", "200", "--edits", "20", "--editors", "2", "--points", "one"});
  EXPECT_EQ(result["edits"], 40);
  EXPECT_EQ(result["editsReplaced"], 0);
  EXPECT_EQ(result["server"]["apply"]["count"], 40);
  EXPECT_EQ(result["editors"]["updateEnd"]["count"], 2 * 40);
  EXPECT_EQ(result["editors"]["decoded"]["count"], 40);  // by the first editor
  EXPECT_GE(result["seconds"], 0.095);                   // the last edit is due then
  EXPECT_EQ(result["pace"], "open loop, 200 edits/s an editor");
  EXPECT_EQ(result["moved"], "one control point");
}

TEST_F(LatticectlBench, AnEditThatNoChunkShowsHasAnUpdateWithoutBytes) {
  const auto result = Bench({"--size", "8,8,8", "--points", "one", "--edits", "1"});
  EXPECT_EQ(result["editors"]["updates"], 1);
  EXPECT_EQ(result["editors"]["bytes"], 0);
  EXPECT_FALSE(result["cpu"]["client"].contains("secondsPerGigabyte"));
}

TEST_F(LatticectlBench, IntervalModeReplacesWhatItCouldNotSend) {
  // No server answers 10,000 batches per second one after the other.
  const auto result = Bench({"--interval", "0.1", "--edits", "400"});
  EXPECT_EQ(result["edits"], 400);
  EXPECT_GT(result["editsReplaced"], 0);
  EXPECT_EQ(result["server"]["apply"]["count"].get<int>(),
            400 - result["editsReplaced"].get<int>());
  EXPECT_EQ(result["editors"]["updateEnd"]["count"], 400);
}

TEST_F(LatticectlBench, DurationEndsTheRun) {
  const auto result = Bench({"--rate", "100", "--duration", "0.2"});
  EXPECT_GT(result["edits"], 0);
  EXPECT_LE(result["edits"], 20);
}

TEST_F(LatticectlBench, StalledAndSlowWatchersAreToldApart) {
  const auto result = Bench({"--watchers", "2", "--slow", "1", "--slow-bytes-per-second", "2000",
                             "--stalled", "2", "--edits", "20"});
  EXPECT_EQ(result["stalled"], 2);
  EXPECT_EQ(result["watchers"]["updateEnd"]["count"], 2 * 20);
  EXPECT_EQ(result["watchers"]["editsUnseen"], 0);
  EXPECT_EQ(result["verified"]["streams"], 1 + 2) << "those that keep up";
  const auto& slow = result["slow"];
  EXPECT_EQ(slow["streams"], 1);
  EXPECT_EQ(slow["editsUnseen"].get<int>() + slow["updateEnd"]["count"].get<int>(), 20);
}

TEST_F(LatticectlBench, UpdatesThatGiveWayAreCountedAsRestartedAndSuperseded) {
  // An update in full detail (1.5 MB) begins 80 ms after an edit and takes three edit intervals to send.
  // If the machine is too busy to begin it before the next edit, a longer interval succeeds.
  nlohmann::json result;
  for (const double interval : {0.2, 0.8, 3.2}) {
    const std::string rate = fmt::format("{}", 1 / interval);
    const std::string bytes = fmt::format("{:.0f}", 500000 / interval);
    result = RunJson({"bench", Path("vase.obj"), "--segments", "8", "--encoding", "raw", "--rate",
                      rate, "--edits", "4", "--max-bytes-per-second", bytes});
    if (result["editors"]["updatesRestarted"] > 0) break;
  }
  EXPECT_EQ(result["editors"]["editsUnseen"], 0);
  EXPECT_GT(result["editors"]["updatesRestarted"], 0);
  EXPECT_GT(result["server"]["updatesSuperseded"], 0);
}

TEST_F(LatticectlBench, PrintsASectionOfADocument) {
  // The command starts its own server, in this process.
  const std::string text = MustRun({"bench", "vase", "--resolution", "1", "--edits", "2",
                                    "--segments", "1", "--encoding", "draco"});
  for (const char* part :
       {"## 1 scene of vase", "closed loop; every second control point moved, draco",
        "| editors: edit to update end ", "| server: encode ",
        "; 0 edits merged, 0 updates restarted", "0 updates superseded by one in less detail",
        "\n* where the time goes: ", "\n* next bottleneck: ", "\n* processor: client and server ",
        " points of 1 stream against EvaluatePoints"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

TEST_F(LatticectlBench, SaysWhichEncodingItChoseAndWhy) {
  const auto open = Bench({"--edits", "1"});
  EXPECT_THAT(open["encoding"], AnyOf("draco", "meshopt"));
  EXPECT_THAT(open["encodingReason"].get<std::string>(), HasSubstr("decoding saves"));
  EXPECT_EQ(Bench({"--edits", "1", "--encoding", "draco"})["encodingReason"], "");
  EXPECT_THAT(Run(Vase({"--edits", "1"})), HasSubstr(": meshopt's 0.2 bytes more a point take "));
}

TEST_F(LatticectlBench, TellsTheServersProcessorTimeWhereItsProcessIsKnown) {
  const auto result = Bench({"--edits", "1", "--server-pid", std::to_string(getpid())});
  EXPECT_GT(result["cpu"]["server"]["secondsPerGigabyte"], 0.0);
  ExpectFailure(Vase({"--edits", "1", "--server-pid", "4194304"}), HasSubstr("no process 4194304"));
}

TEST_F(LatticectlBench, RefusesContradictingPaces) {
  EXPECT_EQ(Latticectl({"bench", "vase", "--rate", "10", "--interval", "10"}).code, 2);
  EXPECT_EQ(Latticectl({"bench", "vase", "--edits", "10", "--duration", "10"}).code, 2);
  EXPECT_EQ(Latticectl({"bench", "vase", "--server-pid", "1"}).code, 2);
}

TEST_F(LatticectlBench, TheServersRefusalNamesTheSceneAndLeavesNothing) {
  Options options = QuietOptions();
  options.max_watchers = 3;
  const auto server = StartServer(options);
  ASSERT_NE(server, nullptr);
  const RunResult refused = Latticectl({"bench", Path("vase.obj"), "--watchers", "3", "--edits",
                                        "1", "--server", server->address()});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("scene "));
  EXPECT_THAT(refused.err, HasSubstr("LIMIT_EXCEEDED"));
  EXPECT_EQ(MustRun({"scene", "list", "--json", "--server", server->address()}), "[]\n");
  EXPECT_EQ(MustRun({"meshes", "--json", "--server", server->address()}), "[]\n");
}

TEST_F(LatticectlBench, AWrongSurfaceAndAnEditMeanwhileAreFound) {
  for (const char* scene : {"scene-one", "scene-two"}) {
    Run({"scene", "create", Path("vase.obj"), "--id", scene, "--segments", "3"});
  }
  const auto move = [this](const char* scene, const char* by) {
    Run({"edit", "move", scene, "--point", "1,1,1", "--point", "2,1,2", "--by", by});
  };
  move("scene-one", "0.2,0,0");
  move("scene-two", "0.2,0,0.01");
  const auto client = Client::Connect({.address = address()});
  v1::GetUpdateRequest request;
  request.set_scene("scene-one");
  const auto surface = client->GetUpdate(request);
  ASSERT_OK(surface);
  VerifiedPoints verified;
  const auto check = [&](const char* scene) {
    return SurfaceVerifier(client.get(), scene).Check(*surface, 0, &verified);
  };

  EXPECT_OK(check("scene-one"));
  EXPECT_THAT(check("scene-two"),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("a point of revision 1 is off by ")));
  move("scene-one", "0,0,0.1");
  EXPECT_THAT(check("scene-one"), StatusIs(absl::StatusCode::kAborted));
}

}  // namespace
}  // namespace latticed::client
