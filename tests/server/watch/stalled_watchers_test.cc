// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Watchers that do not read, beside watchers that do: how much memory they cost, and that nobody waits for
// them. latticectl bench --stalled measures times.
#include <algorithm>
#include <memory>
#include <vector>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

class StalledWatchersTest : public StreamTest {
 protected:
  // Has its own connection with a fixed window, so the client buffers no megabytes that nobody reads.
  struct Watcher {
    Watcher(const std::string& address, const v1::WatchRequest& request)
        : stub(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), Arguments())),
          client(stub, request) {}
    static grpc::ChannelArguments Arguments() {
      grpc::ChannelArguments arguments;
      arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
      arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
      return arguments;
    }
    Scenes stub;
    WatchClient client;
  };
  std::unique_ptr<Watcher> Connect() const { return Connect(Watch()); }
  std::unique_ptr<Watcher> Connect(const v1::WatchRequest& watch) const {
    return std::make_unique<Watcher>(server_->address(), watch);
  }
  static int64_t Restarts(const EventLog& log) {
    return std::ranges::count_if(log.begins, [](const auto& begin) { return begin.restart(); });
  }

  // Moves the whole lattice, which changes every chunk.
  uint64_t EditAll() {
    ++sequence_;
    v1::EditBatch batch = Move(sequence_, 0, sequence_ % 2 == 0 ? 0.01 : -0.01, "bob");
    for (uint32_t i = 1; i < 125; ++i) {
      batch.mutable_edits(0)->mutable_move_control_points()->add_indices(i);
    }
    v1::EditResult result;
    EXPECT_OK(Apply(batch, &result));
    return result.revision();
  }

  uint64_t sequence_ = 0;
};

TEST_F(StalledWatchersTest, CostNoMoreThanARetiredSnapshotAndHoldNobodyUp) {
  constexpr int kPrompt = 8;
  constexpr size_t kMostStalled = 30;
  CreateScene(48);
  std::vector<std::unique_ptr<Watcher>> prompt, stalled;
  for (int i = 0; i < kPrompt; ++i) {
    prompt.push_back(Connect());
    prompt.back()->client.ReadUntilRevision(0);
  }
  const uint64_t one_set = Info().host_bytes().at("chunks");
  ASSERT_GT(one_set, 4u * 65'536) << "more than a stream's window: who does not read is stuck";

  // Each stalled watcher holds another snapshot, until there are too many.
  uint64_t revision = 0;
  while (Info().retired_snapshots() == 0 && stalled.size() < kMostStalled) {
    stalled.push_back(Connect());
    revision = EditAll();
    for (const auto& one : prompt) {
      ASSERT_NO_FATAL_FAILURE(one->client.ReadUntilRevision(revision));
    }
    EXPECT_LE(Info().host_bytes().at("chunks"), 3 * one_set) << "three snapshots of a view";
  }

  EXPECT_EQ(Info().retired_snapshots(), 1u);
  for (const auto& one : prompt) EXPECT_EQ(Restarts(one->client.log), 0);
  int64_t restarts = 0;
  for (const auto& one : stalled) {
    ASSERT_NO_FATAL_FAILURE(one->client.ReadUntilRevision(revision));
    EXPECT_LE(one->client.log.ends.size(), 2u) << "nothing was queued";
    restarts += Restarts(one->client.log);
  }
  EXPECT_GE(restarts, 1) << "whose snapshot was retired begins again with the newest";
  EXPECT_EQ(Metric("latticed_snapshots_retired_total"), 1);
  EXPECT_EQ(Metric("latticed_updates_restarted_total"), static_cast<double>(restarts));
}

// EventLog fails the test if a pattern does not come before its first use, or comes twice.
TEST_F(StalledWatchersTest, HaveEveryPatternWhenTheyBeginAgain) {
  constexpr size_t kMostStalled = 30;
  CreateScene(48);
  v1::WatchRequest watch = Watch();
  watch.mutable_view()->set_tolerance(2e-5);
  watch.mutable_view()->set_segments(32);
  watch.mutable_view()->set_encoding(v1::ENCODING_RAW);
  WatchClient prompt(*scenes_, watch);
  prompt.ReadUntilRevision(0);
  std::vector<std::unique_ptr<Watcher>> stalled;
  uint64_t revision = 0;
  while (Info().retired_snapshots() == 0 && stalled.size() < kMostStalled) {
    stalled.push_back(Connect(watch));
    ++sequence_;  // of an edit that bends every patch
    ASSERT_OK(Apply(Move(sequence_, 62, sequence_ % 2 == 0 ? -0.25 : 0.3, "bob")));
    revision = sequence_;
    ASSERT_NO_FATAL_FAILURE(prompt.ReadUntilRevision(revision));
  }
  EXPECT_EQ(Info().retired_snapshots(), 1u);

  int64_t restarts = 0;
  for (const auto& one : stalled) {
    const EventLog& log = one->client.log;
    ASSERT_NO_FATAL_FAILURE(one->client.ReadUntilRevision(revision));
    restarts += Restarts(log);
    EXPECT_TRUE(log.chunks == prompt.log.chunks);
    EXPECT_TRUE(log.levels == prompt.log.levels);
    EXPECT_EQ(log.ends.back().certified_error(), prompt.log.ends.back().certified_error());
  }
  EXPECT_GE(restarts, 1);
  EXPECT_GT(prompt.log.patterns.size(), 1u);
}

}  // namespace
}  // namespace latticed::testing
