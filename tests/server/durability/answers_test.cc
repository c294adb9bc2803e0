// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Answers on a stream whose edits wait for the store: in the order of the edits, before the updates that contain them, and
// all of them before the stream ends.
#include <memory>
#include <thread>

#include "core/cpu/cpu_backend.h"
#include "server/store/memory_store.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

class AnswersTest : public ServerTest {
 protected:
  void SetUp() override {
    StartServerOn(MakeCpuBackend({.threads = 1}), TestOptions(), store_);
    mesh_ = Upload(kGridObj);
    ASSERT_OK(Create(SceneRequest()));
  }
  void TearDown() override { store_->Resume(); }

  v1::WatchRequest Watch() const {
    v1::WatchRequest request;
    request.set_scene(kScene);
    request.set_editor_id("ann");
    return request;
  }
  static v1::EditBatch Move(uint64_t sequence) { return MoveOne("ann", sequence, 5, {0.01, 0, 0}); }

  const std::shared_ptr<MemoryStore> store_ = std::make_shared<MemoryStore>();
};

TEST_F(AnswersTest, ARefusalDoesNotOvertakeAnEditThatIsBeingStored) {
  DeformClient stream(*scenes_, Watch());
  stream.ReadUntilRevision(0);
  store_->Pause();
  ASSERT_TRUE(stream.Send(Move(1)));
  v1::EditBatch other = Move(2);
  other.set_scene("another-scene");
  ASSERT_TRUE(stream.Send(other));
  ASSERT_TRUE(stream.Send(Move(3)));
  std::thread later([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    store_->Resume();
  });
  stream.ReadUntil([&] { return stream.log.results.size() == 3; });
  later.join();
  EXPECT_EQ(stream.log.results[0].sequence(), 1u);
  EXPECT_EQ(stream.log.results[0].revision(), 1u);
  EXPECT_EQ(stream.log.results[1].sequence(), 2u);
  EXPECT_NE(stream.log.results[1].status().code(), 0);
  EXPECT_EQ(stream.log.results[2].sequence(), 3u);
  EXPECT_EQ(stream.log.results[2].revision(), 2u);
}

TEST_F(AnswersTest, AStreamThatIsHalfClosedEndsAfterAllAnswersAndTheLastUpdate) {
  DeformClient stream(*scenes_, Watch());
  stream.ReadUntilRevision(0);
  store_->Pause();
  for (uint64_t n = 1; n <= 20; ++n) ASSERT_TRUE(stream.Send(Move(n)));
  stream.HalfClose();
  std::thread later([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    store_->Resume();
  });
  EXPECT_OK(stream.Finish());
  later.join();
  ASSERT_EQ(stream.log.results.size(), 20u);
  for (uint64_t n = 1; n <= 20; ++n) EXPECT_EQ(stream.log.results[n - 1].revision(), n);
  EXPECT_EQ(stream.log.ends.back().revision(), 20u);
}

TEST_F(AnswersTest, WhatTheStoreRefusesIsAnsweredWithItsReason) {
  DeformClient stream(*scenes_, Watch());
  stream.ReadUntilRevision(0);
  store_->SetFailure(absl::UnavailableError("a cable was pulled"));
  ASSERT_TRUE(stream.Send(Move(1)));
  stream.ReadUntil([&] { return stream.log.results.size() == 1; });
  EXPECT_EQ(stream.log.results[0].status().code(),
            static_cast<int>(absl::StatusCode::kUnavailable));
  EXPECT_EQ(stream.log.results[0].revision(), 0u);

  store_->SetFailure(absl::OkStatus());
  ASSERT_TRUE(stream.Send(Move(1)));
  stream.ReadUntil([&] { return stream.log.results.size() == 2; });
  EXPECT_EQ(stream.log.results[1].revision(), 1u);
}

TEST_F(AnswersTest, AServerThatStopsWithEditsInItsStoreEnds) {
  DeformClient stream(*scenes_, Watch());
  stream.ReadUntilRevision(0);
  store_->Pause();
  for (uint64_t n = 1; n <= 5; ++n) ASSERT_TRUE(stream.Send(Move(n)));
  std::thread later([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    store_->Resume();
  });
  server_.reset();
  later.join();
}

}  // namespace
}  // namespace latticed::testing
