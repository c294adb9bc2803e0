// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// 'latticectl torture' against two servers that share a store. The first ends while it edits; the second goes on with
// what the store has kept.
#include <atomic>
#include <thread>

#include "absl/time/clock.h"
#include "core/cpu/cpu_backend.h"
#include "tests/client/latticectl_server_fixture.h"
#include "tests/client/torture/losing_store.h"

namespace latticed::client {
namespace {

using ::latticed::testing::Loses;
using ::latticed::testing::LosingStore;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

class LatticectlTorture : public LatticectlServer {
 protected:
  // A torture during which the first server ends, after enough edits for a loss.
  RunResult TortureWith(Loses loses, const std::vector<std::string>& flags = {"--json"}) const {
    RunResult result;
    for (const char* seconds : {"2", "20"}) {  // a busy machine takes longer
      if (TortureFor(seconds, loses, flags, &result)) return result;
    }
    ADD_FAILURE() << "too few edits: " << result.out << result.err;
    return result;
  }
  // False if there were too few edits.
  bool TortureFor(const char* seconds, Loses loses, std::vector<std::string> flags,
                  RunResult* result) const {
    constexpr uint64_t kEnough =
        450;  // four losses: one in twelve records is of a refused edit, which nobody misses
    const auto memory = std::make_shared<SharedMemory>();
    auto store = std::make_shared<LosingStore>(memory, "one", loses);
    auto one = StartOn(store, "one");
    const auto two = StartOn(std::make_shared<SharedMemoryStore>(memory, "two"), "two");
    flags.insert(flags.begin(),
                 {"torture", Path("vase.obj"), "--scenes", "4", "--rate", "100", "--seconds",
                  seconds, "--server", one->address(), "--server", two->address()});
    std::atomic<bool> ended = false;
    std::thread torture([&] {
      *result = Latticectl(flags);
      ended = true;
    });
    while (!ended && store->appends() < kEnough) absl::SleepFor(absl::Milliseconds(2));
    const bool enough = !ended;
    one.reset();
    store.reset();  // gives up its scenes
    torture.join();
    EXPECT_EQ(MustRun({"scene", "list", "--json", "--server", two->address()}), "[]\n");
    return enough;
  }
  static std::unique_ptr<InProcessServer> StartOn(std::shared_ptr<Store> store, const char* name) {
    Options options = QuietOptions();
    options.advertise = name;
    std::vector<std::unique_ptr<Backend>> backends;
    backends.push_back(MakeCpuBackend({.threads = 1}));
    auto server = InProcessServer::Start(options, std::move(backends), std::move(store));
    EXPECT_OK(server);
    return *std::move(server);
  }
  static nlohmann::json Parse(const std::string& json) {
    return nlohmann::json::parse(json, nullptr, /*allow_exceptions=*/false);
  }
};

TEST_F(LatticectlTorture, FindsNothingWhereNothingIsLost) {
  const RunResult result = TortureWith(Loses::kNothing);

  EXPECT_EQ(result.code, 0) << result.err;
  const auto report = Parse(result.out);
  EXPECT_GT(report["acknowledged"], 150);
  for (const char* fault : {"lost", "doubled", "gaps", "acknowledgedTwice", "differing"}) {
    EXPECT_EQ(report[fault], 0) << fault;
  }
  EXPECT_GE(report["compared"], 6);
  EXPECT_GT(report["reconnections"], 0);
  EXPECT_EQ(report["answers"]["count"], report["acknowledged"]);
  EXPECT_LE(report["answers"]["p50Ms"], report["answers"]["maxMs"]);
}

TEST_F(LatticectlTorture, FindsThatEveryHundredthEditIsLost) {
  const RunResult result = TortureWith(Loses::kEveryHundredth);

  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, AllOf(HasSubstr("\"scene "), HasSubstr("revision "),
                                HasSubstr("\"code\":\"DATA_LOSS\"")));
  const auto report = Parse(result.out);
  EXPECT_GT(report["lost"].get<int>() + report["acknowledgedTwice"].get<int>(), 0) << result.out;
  EXPECT_GE(report["faults"].size(), 1u);
}

TEST_F(LatticectlTorture, FindsAnOlderSceneThatLooksWell) {
  const RunResult result = TortureWith(Loses::kTheRest, {});

  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, MatchesRegex("latticectl: scene [0-9a-f]{32}, revision [0-9]+: .*\n"));
  EXPECT_THAT(result.out, AllOf(HasSubstr("acknowledged "), HasSubstr("\nlost "),
                                HasSubstr("\nscene "), HasSubstr("\nseed ")));
}

TEST_F(LatticectlTorture, OfOneServerKeepsItsScenesOnDemand) {
  const auto result = RunJson({"torture", "--scenes", "2", "--editors", "3", "--rate", "50",
                               "--seconds", "2", "--seed", "7", "--keep"});

  EXPECT_GT(result["acknowledged"], 20);
  EXPECT_EQ(result["seed"], 7);
  EXPECT_EQ(result["reconnections"], 0);
  EXPECT_EQ(RunJson({"scene", "list"}).size(), 2u);
  EXPECT_EQ(RunJson({"meshes"}).size(), 1u);
}

TEST_F(LatticectlTorture, SaysThatNoServerAnswers) {
  const RunResult result = Latticectl({"torture", "--server", "127.0.0.1:1", "--retry-for", "0"});
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("no answer from 127.0.0.1:1"));
}

}  // namespace
}  // namespace latticed::client
