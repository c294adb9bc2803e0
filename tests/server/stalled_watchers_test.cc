// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Watchers that do not read, or slowly, beside prompt ones: what they cost the server and the
// others. How long it takes is measured by latticectl bench --stalled.
#include <memory>
#include <string>
#include <vector>

#include "fmt/format.h"
#include "latticed/v1/server.grpc.pb.h"
#include "tests/server/stream_support.h"
#include "tests/server/watch_crowd.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr absl::Duration kPatience = absl::Seconds(60);
constexpr int kPrompt = 40, kSlow = 10;
constexpr size_t kMostStalled = 30;

class StalledWatchersTest : public StreamTest {
 protected:
  // Moves the whole lattice: every chunk changes.
  uint64_t EditAll() {
    ++sequence_;
    v1::EditBatch batch = Move(sequence_, 0, sequence_ % 2 == 0 ? 0.01 : -0.01, "bob");
    for (uint32_t i = 1; i < 125; ++i) {
      batch.mutable_edits(0)->mutable_move_control_points()->add_indices(i);
    }
    v1::EditResult result;
    EXPECT_TRUE(Apply(batch, &result).ok());
    return result.revision();
  }
  std::unique_ptr<WatchCrowd> Crowd(const WatchCrowd::Options& options) {
    return std::make_unique<WatchCrowd>(server_->address(), Watch(), options);
  }

  uint64_t sequence_ = 0;
};

TEST_F(StalledWatchersTest, CostNoMoreThanARetiredSnapshotAndHoldNobodyUp) {
  CreateScene(48);
  const auto prompt = Crowd({.count = kPrompt});
  ASSERT_TRUE(prompt->WaitForRevision(0, kPatience));
  const uint64_t one_set = Info().host_bytes().at("chunks");
  ASSERT_GT(one_set, 4u * 65'536) << "more than a stream's window: who does not read is stuck";
  const auto slow = Crowd({.count = kSlow, .pause = absl::Milliseconds(20)});

  // Each that stalls holds another snapshot, until there are too many.
  std::vector<std::unique_ptr<WatchCrowd>> stalled;
  uint64_t revision = 0;
  while (Info().retired_snapshots() == 0 && stalled.size() < kMostStalled) {
    stalled.push_back(Crowd({.reads = false}));
    revision = EditAll();
    ASSERT_TRUE(prompt->WaitForRevision(revision, kPatience)) << "at revision " << revision;
    EXPECT_LE(Info().host_bytes().at("chunks"), 3 * one_set) << "three snapshots of a view";
  }

  EXPECT_EQ(Info().retired_snapshots(), 1u);
  EXPECT_TRUE(slow->WaitForRevision(revision, kPatience)) << "late, but with the newest";
  EXPECT_EQ(prompt->restarts(), 0u);
  uint64_t restarts = 0;
  for (const auto& one : stalled) {
    EXPECT_EQ(one->updates(), 0u);
    one->ReadOn();
    EXPECT_TRUE(one->WaitForRevision(revision, kPatience));
    EXPECT_LE(one->updates(), 2u) << "nothing was queued";
    restarts += one->restarts();
  }
  EXPECT_GE(restarts, 1u) << "whose snapshot was retired begins again with the newest";
  const std::string metrics = server_->metrics();
  EXPECT_THAT(metrics, HasSubstr("latticed_snapshots_retired_total 1\n"));
  EXPECT_THAT(metrics, HasSubstr(fmt::format("latticed_updates_restarted_total {}\n",
                                             restarts + slow->restarts())));
}

}  // namespace
}  // namespace latticed::testing
