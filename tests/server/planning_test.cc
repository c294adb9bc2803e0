// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// While a plan is made, for a new scene or for an inserted knot: others go on, and a caller that
// has gone is noticed.
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "tests/server/gated_backend.h"
#include "tests/server/scene_fixture.h"
#include "tests/server/stream_support.h"

namespace latticed::testing {
namespace {

class PlanningTest : public SceneFixture {
 protected:
  void SetUp() override {
    auto backend = std::make_unique<GatedBackend>();
    backend_ = backend.get();
    Options options;
    options.heartbeat_interval = absl::Seconds(2);
    ASSERT_NO_FATAL_FAILURE(StartServerOn(std::move(backend), options));
    mesh_ = Upload(kGridObj);
  }
  void TearDown() override { backend_->Open(); }

  // Calls until a call that the gate holds has run into its deadline, and until the server's clock
  // has passed it as well.
  void PassADeadlineAtTheGate(const std::function<grpc::Status(grpc::ClientContext*)>& call) {
    backend_->Close();
    auto timeout = std::chrono::milliseconds(250);
    // A slow server may not get there in time.
    for (; backend_->entries() == 0 && !HasFailure(); timeout *= 2) {
      grpc::ClientContext context;
      context.set_deadline(std::chrono::system_clock::now() + timeout);
      EXPECT_EQ(call(&context).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    }
    // The server's deadline began when the call was there, which it is by now.
    std::this_thread::sleep_for(timeout);
    backend_->Open();
  }

  GatedBackend* backend_ = nullptr;  // the server's
};

TEST_F(PlanningTest, OthersGoOnWhileAKnotIsInserted) {
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Create(SceneRequest("scene-two")));
  DeformClient same(*stub_), other(*stub_);
  v1::WatchRequest watch;
  watch.set_max_unacked_updates(0);
  watch.set_editor_id("bob");
  watch.set_scene("scene-one");
  same.Open(watch);
  watch.set_scene("scene-two");
  other.Open(watch);
  same.ReadUntilRevision(0);
  other.ReadUntilRevision(0);
  backend_->Close();
  auto knot = std::async(std::launch::async, [&] { return Apply(Knot("alice", 1)); });
  ASSERT_TRUE(backend_->WaitForEntries(1));

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

  backend_->Open();
  EXPECT_OK(knot.get());
  const v1::LatticeState after = Lattice();
  EXPECT_EQ(after.structure_id(), 2u);
  EXPECT_EQ(after.revision(), 3u);
}

TEST_F(PlanningTest, ACreationPastItsDeadlineLeavesNothing) {
  PassADeadlineAtTheGate([this](grpc::ClientContext* context) {
    v1::Scene scene;
    return stub_->CreateScene(context, SceneRequest(), &scene);
  });

  EXPECT_OK(DeleteMeshOnceUnused()) << "a scene has come up";
}

TEST_F(PlanningTest, AKnotPastItsDeadlineChangesNothingAndMayBeSentAgain) {
  ASSERT_OK(Create(SceneRequest()));

  PassADeadlineAtTheGate([this](grpc::ClientContext* context) {
    v1::EditResult result;
    return stub_->ApplyEdits(context, Knot("alice", 1), &result);
  });
  // Time to go wrong: an edit that was made all the same would be in the ledger by then.
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(Lattice().revision(), 0u);
  const int plans = backend_->entries();

  ASSERT_OK(Apply(Knot("alice", 1)));
  EXPECT_GT(backend_->entries(), plans) << "not the answer to the first";
  const v1::LatticeState after = Lattice();
  EXPECT_EQ(after.structure_id(), 2u);
  EXPECT_EQ(after.revision(), 1u) << "once";
}

}  // namespace
}  // namespace latticed::testing
