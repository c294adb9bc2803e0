// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The load generator as a user meets it, against a server in this process: what it counts, not how
// long anything takes.
#include <unistd.h>

#include "client/cpp/load/surface_verifier.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Not;

class LatticectlBench : public LatticectlServer {
 protected:
  nlohmann::json Bench(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"bench", Path("vase.obj"), "--segments", "2"});
    return RunJson(std::move(flags));
  }
  RunResult BenchFails(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"bench", Path("vase.obj"), "--segments", "2"});
    return Latticectl(AtServer(std::move(flags)));
  }
};

TEST_F(LatticectlBench, ClosedLoopOfScenesEditorsAndWatchersCountsEveryEdit) {
  const auto result = Bench({"--scenes", "2", "--editors", "2", "--watchers", "3", "--edits", "5"});

  EXPECT_EQ(result["edits"], 2 * 2 * 5);
  EXPECT_EQ(result["editors"]["streams"], 2 * 2);
  EXPECT_EQ(result["watchers"]["streams"], 2 * 3);
  // Every edit of a scene on every stream of it.
  for (const char* latency : {"firstChunk", "updateEnd"}) {
    EXPECT_EQ(result["editors"][latency]["count"], 2 * 2 * 10) << latency;
    EXPECT_EQ(result["watchers"][latency]["count"], 2 * 3 * 10) << latency;
  }
  const auto& end = result["watchers"]["updateEnd"];
  EXPECT_GT(end["p50Ms"], 0.0);
  EXPECT_LE(end["p50Ms"], end["p99Ms"]);
  EXPECT_LE(end["p99Ms"], end["maxMs"]);
  EXPECT_GT(result["editors"]["decoded"]["count"], 0);
  EXPECT_EQ(result["watchers"]["decoded"]["count"], 0);
  EXPECT_GT(result["server"]["encode"]["count"], 0);
  EXPECT_EQ(result["server"]["apply"]["count"], 2 * 2 * 5);
  EXPECT_GT(result["verified"]["points"], 0);
  EXPECT_GT(result["cpu"]["client"]["seconds"], 0.0);

  EXPECT_EQ(RunJson({"scene", "list"}).size(), 0u);
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);
}

TEST_F(LatticectlBench, MergedEditsAndUpdatesAddUpToTheEdits) {
  const auto editors = Bench({"--editors", "3", "--edits", "6", "--decode", "all"})["editors"];
  // Of the edits that a stream sees, each begins an update or shares one.
  EXPECT_EQ(editors["editsUnseen"], 0);
  EXPECT_EQ(editors["editsMerged"].get<int>() + editors["updates"].get<int>(), 3 * 18);
  EXPECT_EQ(editors["decoded"]["count"], 3 * 18);
}

TEST_F(LatticectlBench, OpenLoopSendsEveryEdit) {
  const auto result =
      Bench({"--rate", "200", "--edits", "20", "--editors", "2", "--points", "one"});
  EXPECT_EQ(result["edits"], 40);
  EXPECT_EQ(result["editsReplaced"], 0);
  EXPECT_EQ(result["server"]["apply"]["count"], 40);
  EXPECT_EQ(result["editors"]["updateEnd"]["count"], 2 * 40);
  EXPECT_EQ(result["editors"]["decoded"]["count"], 40);  // the first editor's
  EXPECT_GE(result["seconds"], 0.095);                   // the last one is due then
  EXPECT_EQ(result["pace"], "open loop, 200 edits/s an editor");
  EXPECT_EQ(result["moved"], "one point");
}

TEST_F(LatticectlBench, AnEditThatNoChunkShowsHasAnUpdateWithoutBytes) {
  const std::vector<std::string> flags{"--size", "8,8,8", "--points", "one", "--edits", "1"};
  const auto result = Bench(flags);
  EXPECT_EQ(result["editors"]["updates"], 1);
  EXPECT_EQ(result["editors"]["bytes"], 0);
  EXPECT_FALSE(result["cpu"]["client"].contains("secondsPerGigabyte"));
  std::vector<std::string> bench{"bench", Path("vase.obj"), "--segments", "2"};
  bench.insert(bench.end(), flags.begin(), flags.end());
  EXPECT_THAT(Run(bench), Not(HasSubstr("s/GB")));
}

TEST_F(LatticectlBench, IntervalModeReplacesWhatItCouldNotSend) {
  // No server answers ten thousand batches a second, one after the other.
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
  const auto& slow = result["slow"];
  EXPECT_EQ(slow["streams"], 1);
  EXPECT_EQ(slow["editsUnseen"].get<int>() + slow["updateEnd"]["count"].get<int>(), 20);
}

TEST_F(LatticectlBench, PrintsATableAndAppendsItToADocument) {
  const std::vector<std::string> bench{
      "bench", "vase",       "--resolution", "1", "--edits", "2", "--segments",
      "1",     "--markdown", Path("load.md")};
  const std::string text = Run(bench);
  EXPECT_THAT(text, HasSubstr("1 scene of vase"));
  EXPECT_THAT(text, HasSubstr("editors: edit to update end"));
  Run(bench);
  const auto document = ReadFile(Path("load.md"));
  ASSERT_OK(document);
  EXPECT_THAT(*document, HasSubstr("| server: encode |"));
  EXPECT_NE(document->find("## 1 scene"), document->rfind("## 1 scene"));
}

TEST_F(LatticectlBench, TellsTheServersProcessorTimeWhereItsProcessIsKnown) {
  const auto result = Bench({"--edits", "1", "--server-pid", std::to_string(getpid())});
  EXPECT_GT(result["cpu"]["server"]["secondsPerGigabyte"], 0.0);
  const RunResult unknown = BenchFails({"--edits", "1", "--server-pid", "4194304"});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("no process 4194304"));
}

TEST_F(LatticectlBench, RefusesContradictingPaces) {
  EXPECT_EQ(BenchFails({"--rate", "10", "--interval", "10"}).code, 2);
  EXPECT_EQ(BenchFails({"--edits", "10", "--duration", "10"}).code, 2);
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

class SurfaceVerifierTest : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    for (const char* scene : {"scene-one", "scene-two"}) {
      Run({"scene", "create", Path("vase.obj"), "--id", scene, "--segments", "3"});
    }
    Move("scene-one", "0.2,0,0");
    Move("scene-two", "0.1,0,0");
  }
  void Move(const std::string& scene, const std::string& by) const {
    Run({"edit", "move", scene, "--point", "1,1,1", "--point", "2,1,2", "--by", by});
  }
  Surface Fetch(const std::string& scene) const {
    v1::GetUpdateRequest request;
    request.set_scene(scene);
    request.mutable_view()->set_normals(v1::NORMAL_MODE_FACET);
    auto surface = client_->GetUpdate(request);
    EXPECT_OK(surface);
    return surface.ok() ? *std::move(surface) : Surface();
  }

  const std::unique_ptr<Client> client_ = Client::Connect({.address = address()});
};

TEST_F(SurfaceVerifierTest, ComparesPointsAndNormals) {
  SurfaceVerifier verifier(client_.get(), "scene-one", /*fused=*/true);
  EXPECT_OK(verifier.Check(Fetch("scene-one"), 0));
  EXPECT_GT(verifier.result().positions, 1000u);
  EXPECT_GT(verifier.result().normals, 1000u);
  EXPECT_LE(verifier.result().worst_position, 1.0);
  EXPECT_GT(verifier.result().worst_position, 0.1);  // the rounding is there
}

TEST_F(SurfaceVerifierTest, FindsASurfaceThatIsNotTheScenes) {
  SurfaceVerifier verifier(client_.get(), "scene-one", /*fused=*/true);
  const absl::Status status = verifier.Check(Fetch("scene-two"), 0);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(std::string(status.message()), HasSubstr("times what is allowed"));
}

TEST_F(SurfaceVerifierTest, AnEditMeanwhileIsNoMismatch) {
  const Surface surface = Fetch("scene-one");
  Move("scene-one", "0,0.1,0");
  SurfaceVerifier verifier(client_.get(), "scene-one", /*fused=*/true);
  EXPECT_THAT(verifier.Check(surface, 0), StatusIs(absl::StatusCode::kAborted));
}

}  // namespace
}  // namespace latticed::client
