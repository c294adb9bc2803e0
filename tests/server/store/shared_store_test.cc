// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What store.h promises of servers that share a store.
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/shared_memory_store.h"
#include "server/store/store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/server/store/store_family.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SharedStore : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    ASSERT_OK(first_->CreateScene("gear", "header"));
    ASSERT_OK(AppendTo(*first_, "gear", 1, "of first"));
  }
  // Whom the server is told that the scene belongs to.
  static std::string OwnerFor(Store& store, std::string_view scene) {
    const absl::StatusOr<SceneClaim> claim = store.ClaimScene(scene);
    return claim.ok() ? claim->owner : claim.status().ToString();
  }

  const std::unique_ptr<StoreFamily> family_ = MakeStoreFamily(GetParam());
  std::unique_ptr<Store> first_ = family_->Join("host-1:50051");
  std::unique_ptr<Store> second_ = family_->Join("host-2:50051");
};

TEST_P(SharedStore, TellsWhoOwnsAScene) {
  EXPECT_TRUE(first_->shared());
  EXPECT_EQ(OwnerFor(*second_, "gear"), "host-1:50051");
  EXPECT_EQ(OwnerFor(*first_, "gear"), "");
  EXPECT_THAT(second_->ClaimScene("knot"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("'knot'")));
}

TEST_P(SharedStore, WhoIsNotTheOwnerIsRefused) {
  EXPECT_THAT(AppendTo(*second_, "gear", 2, "x"),
              StatusIs(absl::StatusCode::kAborted, HasSubstr("does not own")));
  EXPECT_EQ(error::DetailsOf(AppendTo(*second_, "gear", 2, "x")).reason, "STORE");
  EXPECT_THAT(AppendTo(*second_, "gear", 0, ""), StatusIs(absl::StatusCode::kAborted));
  EXPECT_THAT(second_->ReadScene("gear"), StatusIs(absl::StatusCode::kAborted));
  EXPECT_THAT(second_->DeleteScene("gear"), StatusIs(absl::StatusCode::kAborted));
  EXPECT_THAT(second_->CreateScene("gear", ""), StatusIs(absl::StatusCode::kAlreadyExists));
  second_->PutSnapshot("gear", 1, "of second");
  second_->Flush();

  EXPECT_OK(AppendTo(*first_, "gear", 2, "of first"));
  ASSERT_OK_AND_ASSIGN(const SceneLog log, first_->ReadScene("gear"));
  EXPECT_EQ(log.snapshot_lsn, 0U);
  EXPECT_THAT(log.records, ElementsAre("of first", "of first"));
  EXPECT_OK(second_->Admit());
}

TEST_P(SharedStore, WhoIsNotTheOwnerMayCopy) {
  ASSERT_OK(first_->CreateSceneAt("knot", "of a knot", 2, "two records"));
  ASSERT_OK(AppendTo(*first_, "knot", 3, "third"));

  ASSERT_OK_AND_ASSIGN(const SceneLog copy, second_->CopyScene("knot"));
  EXPECT_EQ(copy.header, "of a knot");
  EXPECT_EQ(copy.snapshot, "two records");
  EXPECT_EQ(copy.lsn(), 3U);
  EXPECT_OK(AppendTo(*first_, "knot", 4, "fourth"));
}

TEST_P(SharedStore, AReleasedSceneIsAnyones) {
  ASSERT_OK(second_->ReleaseScene("gear"));  // it is not the second's
  EXPECT_EQ(OwnerFor(*second_, "gear"), "host-1:50051");

  ASSERT_OK(first_->ReleaseScene("gear"));

  EXPECT_EQ(OwnerFor(*second_, "gear"), "");
  ASSERT_OK_AND_ASSIGN(const SceneLog log, second_->ReadScene("gear"));
  EXPECT_THAT(log.records, ElementsAre("of first"));
  EXPECT_OK(AppendTo(*second_, "gear", 2, "of second"));
  EXPECT_THAT(AppendTo(*first_, "gear", 2, "x"), StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(OwnerFor(*first_, "gear"), "host-2:50051");
}

TEST_P(SharedStore, AReleaseComesAfterTheAppends) {
  std::vector<std::future<absl::Status>> answers;
  for (uint64_t lsn = 2; lsn <= 200; ++lsn) {
    const auto answer = std::make_shared<std::promise<absl::Status>>();
    answers.push_back(answer->get_future());
    first_->Append("gear", lsn, "of first",
                   [answer](const absl::Status& status) { answer->set_value(status); });
  }
  ASSERT_OK(first_->ReleaseScene("gear"));

  for (auto& answer : answers) EXPECT_OK(answer.get());
  EXPECT_EQ(OwnerFor(*second_, "gear"), "");
  ASSERT_OK_AND_ASSIGN(const SceneLog log, second_->ReadScene("gear"));
  EXPECT_EQ(log.lsn(), 200U);
}

TEST_P(SharedStore, AServerThatEndsLeavesItsScenes) {
  first_.reset();

  EXPECT_EQ(OwnerFor(*second_, "gear"), "");
  EXPECT_OK(second_->ReadScene("gear").status());
  EXPECT_OK(AppendTo(*second_, "gear", 2, "of second"));
}

TEST_P(SharedStore, AFencedServerWritesNothingMore) {
  family_->Fence("host-1:50051");

  EXPECT_EQ(OwnerFor(*second_, "gear"), "");
  EXPECT_THAT(AppendTo(*first_, "gear", 2, "x"), StatusIs(absl::StatusCode::kAborted));
  EXPECT_OK(second_->ReadScene("gear").status());
  EXPECT_OK(AppendTo(*second_, "gear", 2, "of second"));
  ASSERT_OK_AND_ASSIGN(const SceneLog log, second_->ReadScene("gear"));
  EXPECT_THAT(log.records, ElementsAre("of first", "of second"));
}

TEST_P(SharedStore, AFencedServerIsToldAndGoesOn) {
  std::promise<void> told;
  first_->OnFenced([&] { told.set_value(); });
  family_->Fence("host-1:50051");
  ASSERT_EQ(told.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);

  EXPECT_OK(first_->CreateScene("knot", ""));
  EXPECT_OK(AppendTo(*first_, "knot", 1, "x"));
  EXPECT_EQ(OwnerFor(*first_, "gear"), "");
  EXPECT_OK(first_->ReadScene("gear").status());
  EXPECT_OK(AppendTo(*first_, "gear", 2, "x"));
  first_->OnFenced(nullptr);
}

TEST_P(SharedStore, WhatNoServerHasExpires) {
  const auto unused = [&] { return second_->Scenes().value().at(0).unused; };
  EXPECT_EQ(unused(), absl::ZeroDuration());
  ASSERT_OK(second_->ExpireScene("gear", absl::ZeroDuration()));
  ASSERT_OK(first_->ExpireScene("gear", absl::ZeroDuration()));
  EXPECT_OK(AppendTo(*first_, "gear", 2, "of first")) << "a server has it";

  ASSERT_OK(first_->ReleaseScene("gear"));
  absl::SleepFor(absl::Milliseconds(2));
  EXPECT_GE(unused(), absl::Milliseconds(2));
  EXPECT_LT(unused(), absl::Minutes(10));
  ASSERT_OK(second_->ExpireScene("gear", absl::Minutes(10)));
  EXPECT_EQ(OwnerFor(*first_, "gear"), "") << "it was used since";
  EXPECT_EQ(unused(), absl::ZeroDuration());

  ASSERT_OK(first_->ReleaseScene("gear"));
  absl::SleepFor(absl::Milliseconds(2));
  ASSERT_OK(second_->ExpireScene("gear", absl::Milliseconds(1)));
  EXPECT_THAT(first_->ClaimScene("gear"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_OK(second_->ExpireScene("gear", absl::ZeroDuration()));
  ASSERT_OK(first_->CreateScene("gear", "another"));
  ASSERT_OK_AND_ASSIGN(const SceneLog log, first_->ReadScene("gear"));
  EXPECT_EQ(log.lsn(), 0U);
}

TEST_P(SharedStore, WhatALostServerHadExpires) {
  family_->Fence("host-1:50051");
  absl::SleepFor(absl::Milliseconds(2));

  ASSERT_OK(second_->ExpireScene("gear", absl::Minutes(10)));
  EXPECT_OK(second_->ReadSceneHeader("gear").status());
  // Its lease has told when it was there last.
  for (int i = 0; i < 6'000 && second_->ReadSceneHeader("gear").ok(); ++i) {
    ASSERT_OK(second_->ExpireScene("gear", absl::Milliseconds(1)));
    absl::SleepFor(absl::Milliseconds(10));
  }
  EXPECT_THAT(second_->ReadSceneHeader("gear"), StatusIs(absl::StatusCode::kNotFound));
}

TEST_P(SharedStore, ListsAndMeshesAreOfAll) {
  const std::string mesh = Sha256Hex("bytes");
  ASSERT_OK(first_->PutMesh(mesh, "of a mesh", "bytes"));
  ASSERT_OK(second_->CreateScene("knot", "header of knot"));

  ASSERT_OK_AND_ASSIGN(const std::vector<StoredEntry> scenes, second_->Scenes());
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_EQ(scenes[0].id, "gear");
  EXPECT_EQ(scenes[1].id, "knot");
  ASSERT_OK_AND_ASSIGN(const std::string header, second_->ReadSceneHeader("gear"));
  EXPECT_EQ(header, "header");
  ASSERT_OK_AND_ASSIGN(const std::string bytes, second_->ReadMesh(mesh));
  EXPECT_EQ(bytes, "bytes");
  EXPECT_OK(second_->DeleteMesh(mesh));
  EXPECT_THAT(first_->ReadMesh(mesh), StatusIs(absl::StatusCode::kNotFound));
}

TEST_P(SharedStore, ServersTellTheirFreeMemory) {
  second_->SetFreeBytes(12'345);

  std::vector<StoredServer> servers;
  for (int i = 0; i < 6'000 && (servers.size() < 2 || servers[1].free_bytes == 0); ++i) {
    ASSERT_OK_AND_ASSIGN(servers, first_->Servers());
    absl::SleepFor(absl::Milliseconds(10));
  }

  ASSERT_EQ(servers.size(), 2U);
  EXPECT_EQ(servers[0].name, "host-1:50051");
  EXPECT_EQ(servers[0].free_bytes, 0U);
  EXPECT_EQ(servers[1].name, "host-2:50051");
  EXPECT_EQ(servers[1].free_bytes, 12'345U);
  second_.reset();
  ASSERT_OK_AND_ASSIGN(servers, first_->Servers());
  EXPECT_EQ(servers.size(), 1U);
}

TEST(SharedMemoryStore, AClaimWaitsForALeaseThatRunsOut) {
  const auto memory = std::make_shared<SharedMemory>();
  SharedMemoryStore first(memory, "host-1:50051"), second(memory, "host-2:50051");
  ASSERT_OK(first.CreateScene("gear", ""));
  memory->Silence("host-1:50051");
  std::future<std::string> owner = std::async(std::launch::async, [&] {
    return second.ClaimScene("gear").value_or(SceneClaim{"?"}).owner;
  });
  EXPECT_EQ(owner.wait_for(std::chrono::milliseconds(100)), std::future_status::timeout);
  memory->Fence("host-1:50051");

  EXPECT_EQ(owner.get(), "");
  EXPECT_OK(second.ReadScene("gear").status());
}

INSTANTIATE_TEST_SUITE_P(Stores, SharedStore, ::testing::ValuesIn(WithPostgres({"shared_memory"})),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
