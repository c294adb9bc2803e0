// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shares where two servers share a store: what one does counts on the other after Tend. Time is an argument.
#include "server/stores/share_store.h"

#include <gmock/gmock.h>

#include "absl/time/clock.h"
#include "server/store/shared_memory_store.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class ShareStoreTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_OK(a_store_.CreateScene("acme/cow", ""));
    ASSERT_OK(b_.Read(now_));
  }
  ShareStore::Made Made(absl::Duration ttl = absl::Hours(1)) {
    auto made = a_.Create({.scene = "acme/cow",
                           .scene_create_time = absl::UnixEpoch(),
                           .mesh = "acme/of-the-cow",
                           .role = Role::kEdit,
                           .creator = "ada",
                           .expire_time = now_ + ttl},
                          now_);
    EXPECT_OK(made);
    return *made;
  }

  const absl::Time now_ = absl::Now();
  std::shared_ptr<SharedMemory> memory_ = std::make_shared<SharedMemory>();
  SharedMemoryStore a_store_{memory_, "a"}, b_store_{memory_, "b"};
  ShareStore a_{&a_store_}, b_{&b_store_};
};

TEST_F(ShareStoreTest, AnotherServerKnowsAShareAfterItHasRead) {
  const auto made = Made();
  EXPECT_OK(a_.CallerOf(made.token, now_));
  EXPECT_THAT(b_.CallerOf(made.token, now_),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("yet")));

  b_.Tend(now_);

  ASSERT_OK_AND_ASSIGN(const Caller caller, b_.CallerOf(made.token, now_));
  EXPECT_EQ(caller.name, "share:" + made.share.id);
  EXPECT_EQ(caller.role, Role::kEdit);
  EXPECT_EQ(caller.tenant, "acme");
  EXPECT_EQ(caller.expires, now_ + absl::Hours(1));
  ASSERT_TRUE(caller.shared.has_value());
  EXPECT_EQ(caller.shared->scene, "acme/cow");
  EXPECT_EQ(caller.shared->mesh, "acme/of-the-cow");
  EXPECT_EQ(caller.shared->scene_create_time, absl::UnixEpoch());
  ASSERT_EQ(b_.Of("acme/cow").size(), 1U);
  EXPECT_EQ(b_.Of("acme/cow")[0].creator, "ada");
}

TEST_F(ShareStoreTest, ARevocationReachesTheOtherServer) {
  const auto made = Made();
  b_.Tend(now_);
  ASSERT_OK_AND_ASSIGN(const Caller caller, b_.CallerOf(made.token, now_));
  ASSERT_OK(a_.Revoke("acme/cow", made.share.id));
  EXPECT_FALSE(caller.shared->ended.stop_requested());

  b_.Tend(now_);

  EXPECT_TRUE(caller.shared->ended.stop_requested());
  EXPECT_FALSE(b_.CallerOf(made.token, now_).ok());
  EXPECT_EQ(b_.Of("acme/cow").size(), 0U);
}

TEST_F(ShareStoreTest, AnOldTokenThatNobodyKnowsIsWrong) {
  const auto made = Made();
  ASSERT_OK(a_.Revoke("acme/cow", made.share.id));
  std::string token = made.token;
  EXPECT_THAT(b_.CallerOf(token, now_), StatusIs(absl::StatusCode::kUnavailable))
      << "b may not have read the share yet";
  const std::string hour_ago = fmt::format("{:08x}", absl::ToUnixSeconds(now_ - absl::Hours(1)));
  const std::string future = fmt::format("{:08x}", absl::ToUnixSeconds(now_ + absl::Hours(1)));
  for (const std::string& time : {hour_ago, future, std::string("no hex!!")}) {
    token.replace(6, 8, time);
    EXPECT_THAT(b_.CallerOf(token, now_), StatusIs(absl::StatusCode::kUnauthenticated)) << time;
  }
}

TEST_F(ShareStoreTest, WhatExpiresIsDeleted) {
  const auto made = Made(absl::Seconds(10));
  ASSERT_OK_AND_ASSIGN(const Caller caller, a_.CallerOf(made.token, now_));
  a_.Tend(now_ + absl::Seconds(10));

  EXPECT_TRUE(caller.shared->ended.stop_requested());
  EXPECT_THAT(a_.CallerOf(made.token, now_), StatusIs(absl::StatusCode::kUnauthenticated));
  EXPECT_EQ(a_store_.Shares()->size(), 0U);
}

TEST_F(ShareStoreTest, AStoreThatFailsChangesNothing) {
  const auto made = Made();
  memory_->all().SetFailure(absl::UnavailableError("no disk"));

  EXPECT_THAT(a_.Revoke("acme/cow", made.share.id), StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_OK(a_.CallerOf(made.token, now_));
  EXPECT_THAT(a_.Create({.scene = "acme/cow", .expire_time = now_}, now_),
              StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_EQ(a_.Of("acme/cow").size(), 1U);
}

// As another server's call would come while the store is read.
class BusyStore : public SharedMemoryStore {
 public:
  using SharedMemoryStore::SharedMemoryStore;
  absl::StatusOr<std::vector<StoredEntry>> Shares() override {
    auto shares = SharedMemoryStore::Shares();
    if (meanwhile != nullptr) meanwhile();
    return shares;
  }
  std::function<void()> meanwhile;
};

TEST_F(ShareStoreTest, WhatIsDoneWhileTheStoreIsReadCounts) {
  BusyStore store(memory_, "c");
  ShareStore busy(&store);
  ASSERT_OK(busy.Read(now_));
  const auto first = Made(), second = Made();
  std::string third;
  store.meanwhile = [&] {
    const Share share{.scene = "acme/cow", .expire_time = now_ + absl::Hours(1)};
    third = busy.Create(share, now_)->token;
  };
  busy.Tend(now_);
  EXPECT_OK(busy.CallerOf(third, now_)) << "made meanwhile";
  EXPECT_OK(busy.CallerOf(first.token, now_)) << "read all the same";
  store.meanwhile = [&] { EXPECT_OK(busy.Revoke("acme/cow", second.share.id)); };
  busy.Tend(now_);
  EXPECT_FALSE(busy.CallerOf(second.token, now_).ok()) << "revoked meanwhile";
  EXPECT_OK(busy.CallerOf(third, now_));
}

TEST_F(ShareStoreTest, ADamagedShareIsLeftOut) {
  const auto made = Made();
  ASSERT_OK(a_store_.PutShare("0000000000000000", "acme/cow", "\xff\xff"));
  b_.Tend(now_);
  EXPECT_EQ(b_.Of("acme/cow").size(), 1U);
  EXPECT_OK(b_.CallerOf(made.token, now_));
}

TEST_F(ShareStoreTest, ASceneThatAnotherServerDeletedIsSharedNoMore) {
  const auto made = Made();
  b_.Tend(now_);
  ASSERT_OK_AND_ASSIGN(const Caller caller, b_.CallerOf(made.token, now_));
  ASSERT_OK(a_store_.DeleteScene("acme/cow"));
  b_.Tend(now_);
  EXPECT_TRUE(caller.shared->ended.stop_requested());
}

}  // namespace
}  // namespace latticed::testing
