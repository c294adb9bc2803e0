// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// While the plan for an inserted knot is made, other calls go on, and a caller past its deadline is noticed.
#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "tests/server/support/scripted_backend.h"
#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

class PlanningTest : public SceneFixture {
 protected:
  void SetUp() override {
    auto backend = std::make_unique<ScriptedBackend>();
    script_ = &backend->script();
    ASSERT_NO_FATAL_FAILURE(
        StartServerOn(std::move(backend), {.heartbeat_interval = absl::Seconds(2)}));
    mesh_ = Upload(kGridObj);
  }
  void TearDown() override { script_->Release(); }

  Script* script_ = nullptr;  // of the server's backend
};

TEST_F(PlanningTest, OthersGoOnWhileAKnotIsInserted) {
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Create(SceneRequest("scene-two")));
  auto watch = For<v1::WatchRequest>();
  watch.set_max_unacked_updates(0);
  watch.set_editor_id("bob");
  DeformClient same(*scenes_, watch);
  watch.set_scene("scene-two");
  DeformClient other(*scenes_, watch);
  same.ReadUntilRevision(0);
  other.ReadUntilRevision(0);
  script_->HoldNext(Step::kPrepare);
  auto knot = std::async(std::launch::async, [&] { return Apply(Knot("alice", 1)); });
  ASSERT_TRUE(script_->WaitForHeld());

  EXPECT_EQ(Lattice().structure_id(), 1u);
  EXPECT_OK(Apply(Move("carol", 1, 0, 0.1)));
  ASSERT_TRUE(same.Send(Move("bob", 1, 1, 0.1)));
  same.ReadUntilRevision(2);
  v1::EditBatch elsewhere = Move("bob", 1, 1, 0.1);
  elsewhere.set_scene("scene-two");
  ASSERT_TRUE(other.Send(elsewhere));
  other.ReadUntilRevision(1);
  for (DeformClient* client : {&same, &other}) {
    const size_t before = client->log.heartbeats;
    client->ReadUntil([&] { return client->log.heartbeats > before; });
  }
  EXPECT_EQ(knot.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  EXPECT_EQ(Lattice().revision(), 2u);

  script_->Release();
  EXPECT_OK(knot.get());
  const v1::LatticeState after = Lattice();
  EXPECT_EQ(after.structure_id(), 2u);
  EXPECT_EQ(after.revision(), 3u);
}

TEST_F(PlanningTest, AKnotPastItsDeadlineChangesNothingAndMayBeSentAgain) {
  ASSERT_OK(Create(SceneRequest()));
  script_->HoldNext(Step::kPrepare, 100);
  // A slow server may not reach Prepare before the deadline.
  for (auto timeout = std::chrono::milliseconds(250); script_->held() == 0; timeout *= 2) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + timeout);
    v1::EditResult result;
    ASSERT_EQ(scenes_->ApplyEdits(&context, Knot("alice", 1), &result).error_code(),
              grpc::StatusCode::DEADLINE_EXCEEDED);
    // The server's clock for the call started by now, so it too is past the deadline after this.
    std::this_thread::sleep_for(timeout);
  }
  // The metric shows that the server has finished the call: the client may have cancelled it before the server's clock
  // reached the deadline.
  script_->Release();
  const auto finished = [&](const char* code) {
    return Metric(fmt::format(
        R"(latticed_rpc_finished_total{{method="SceneService/ApplyEdits",code="{}"}})", code));
  };
  EXPECT_TRUE(Becomes(
      2'000, [&] { return finished("DEADLINE_EXCEEDED") > 0 || finished("CANCELLED") > 0; }));
  EXPECT_EQ(Lattice().revision(), 0u);

  const int plans = script_->calls(Step::kPrepare);
  ASSERT_OK(Apply(Knot("alice", 1)));
  EXPECT_GT(script_->calls(Step::kPrepare), plans) << "not the answer to the first";
  const v1::LatticeState after = Lattice();
  EXPECT_EQ(after.structure_id(), 2u);
  EXPECT_EQ(after.revision(), 1u) << "once";
}

}  // namespace
}  // namespace latticed::testing
