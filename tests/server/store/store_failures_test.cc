// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A medium that refuses to write, for every store.
#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/store.h"
#include "tests/server/store/fault_vfs.h"
#include "tests/server/store/opened_store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/support/becomes.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class StoreFailures : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    ASSERT_OK(store_->CreateScene("gear", "header"));
    ASSERT_OK(store_->CreateScene("knot", "header"));
    ASSERT_OK(store_.Append("gear", 1, "gear 1"));
  }

  OpenedStore store_{GetParam()};
};

TEST_P(StoreFailures, AFullMediumRefusesAndSaysWhenToTryAgain) {
  store_.SetFull(true);

  const absl::Status refused = store_.Append("gear", 2, "gear 2");

  EXPECT_THAT(refused,
              StatusIs(absl::StatusCode::kResourceExhausted, ::testing::Not(HasSubstr("/"))))
      << "clients are told a path";
  EXPECT_EQ(error::DetailsOf(refused).reason, "STORE");
  EXPECT_GT(error::DetailsOf(refused).retry_after_ms, 0U);
  EXPECT_THAT(store_->Admit(), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(store_->CreateScene("new", ""), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(store_->DeleteScene("knot"), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(store_->PutMesh(Sha256Hex("x"), "", "x"),
              StatusIs(absl::StatusCode::kResourceExhausted));
}

TEST_P(StoreFailures, ReadingGoesOnWhileTheMediumIsFull) {
  store_.SetFull(true);
  EXPECT_THAT(store_.Append("gear", 2, "gear 2"), StatusIs(absl::StatusCode::kResourceExhausted));

  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  ASSERT_OK_AND_ASSIGN(const std::vector<StoredEntry> scenes, store_->Scenes());

  EXPECT_THAT(log.records, ElementsAre("gear 1"));
  EXPECT_EQ(scenes.size(), 2U);
}

TEST_P(StoreFailures, ABrokenSceneTakesNothingUntilItIsRead) {
  store_.SetFull(true);
  EXPECT_THAT(store_.Append("gear", 2, "gear 2"), StatusIs(absl::StatusCode::kResourceExhausted));
  store_.SetFull(false);
  ASSERT_TRUE(store_.AdmitsAgain());

  EXPECT_THAT(store_.Append("gear", 2, "gear 2"), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(store_.Append("gear", 3, "gear 3"), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(store_.Barrier("gear"), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_OK(store_.Append("knot", 1, "knot 1"));
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_THAT(log.records, ElementsAre("gear 1"));

  EXPECT_OK(store_.Append("gear", 2, "gear 2 again"));
  EXPECT_OK(store_.Barrier("gear"));
  ASSERT_OK_AND_ASSIGN(const SceneLog after, store_->ReadScene("gear"));
  EXPECT_THAT(after.records, ElementsAre("gear 1", "gear 2 again"));
}

TEST_P(StoreFailures, WhatWasStoredAndRefusedIsCounted) {
  store_->PutSnapshot("gear", 1, "a snapshot");
  store_->Flush();
  store_.SetFull(true);
  EXPECT_THAT(store_.Append("gear", 2, "gear 2"), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(store_.Append("gear", 2, "gear 2"), StatusIs(absl::StatusCode::kResourceExhausted));

  const StoreCounts& counts = store_->counts();
  EXPECT_EQ(counts.appends_stored, 1U);
  EXPECT_EQ(counts.append_bytes, 6U);
  EXPECT_EQ(counts.snapshots_stored, 1U);
  EXPECT_EQ(counts.snapshot_bytes, 10U);
  EXPECT_EQ(counts.appends_refused, 2U);
  EXPECT_EQ(counts.scenes_broken, 1U);
  EXPECT_EQ(counts.failures, 1U);
  EXPECT_FALSE(counts.writable);

  store_.SetFull(false);
  EXPECT_TRUE(store_.AdmitsAgain());
  EXPECT_TRUE(counts.writable);
  store_->Flush();
  EXPECT_TRUE(Becomes(500, [&] { return counts.waiting_writes == 0; }));
  EXPECT_EQ(counts.waiting_bytes, 0U);
}

TEST_P(StoreFailures, ARecordThatIsNotTheNextBreaksItsScene) {
  EXPECT_THAT(store_.Append("gear", 3, "x"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "scene 'gear': record 3 was appended where 2 is next"));
  EXPECT_THAT(store_.Append("gear", 2, "x"), StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_OK(store_.Append("knot", 1, "x"));

  ASSERT_OK(store_->ReadScene("gear").status());
  EXPECT_OK(store_.Append("gear", 2, "x"));
}

TEST_P(StoreFailures, ASnapshotThatFailsChangesNothing) {
  ASSERT_OK(store_.Append("gear", 2, "gear 2"));
  store_.SetFull(true);
  store_->PutSnapshot("gear", 2, "state 2");
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.snapshot_lsn, 0U);
  EXPECT_THAT(log.records, ElementsAre("gear 1", "gear 2"));

  store_.SetFull(false);
  ASSERT_TRUE(store_.AdmitsAgain());
  EXPECT_OK(store_.Append("gear", 3, "gear 3"));
}

TEST_P(StoreFailures, AnswersToManyScenesAreRightWhenTheMediumFillsUp) {
  constexpr int kScenes = 20;
  constexpr uint64_t kRecords = 50;
  const auto id = [](int scene) { return "scene " + std::to_string(scene); };
  for (int scene = 0; scene < kScenes; ++scene) ASSERT_OK(store_->CreateScene(id(scene), ""));
  std::vector<uint64_t> acknowledged(kScenes);

  for (uint64_t lsn = 1; lsn <= kRecords; ++lsn) {
    if (lsn == kRecords / 2) store_.SetFull(true);
    for (int scene = 0; scene < kScenes; ++scene) {
      uint64_t& last = acknowledged[static_cast<size_t>(scene)];
      store_->Append(id(scene), lsn, std::to_string(lsn), [&last, lsn](const absl::Status& status) {
        if (status.ok()) {
          EXPECT_EQ(std::exchange(last, lsn), lsn - 1);
        }
      });
    }
  }
  for (int scene = 0; scene < kScenes; ++scene) store_.Barrier(id(scene)).IgnoreError();
  store_.SetFull(false);

  for (int scene = 0; scene < kScenes; ++scene) {
    ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene(id(scene)));
    EXPECT_EQ(log.lsn(), acknowledged[static_cast<size_t>(scene)]);
    for (uint64_t i = 0; i < log.records.size(); ++i) {
      EXPECT_EQ(log.records[i], std::to_string(i + 1));
    }
  }
}

TEST_P(StoreFailures, ASlowMediumBoundsWhatWaits) {
  constexpr int kMost = 200;
  const std::string record(1U << 20, 'x');
  std::atomic<uint64_t> answered = 0;
  store_.SetStalled(true);

  uint64_t appended = 1;
  absl::Status refused;
  while (appended < kMost && (refused = store_->Admit()).ok()) {
    store_->Append("gear", ++appended, record, [&](const absl::Status& status) {
      if (status.ok()) ++answered;
    });
  }

  EXPECT_THAT(refused,
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("wait to be written")));
  EXPECT_GT(error::DetailsOf(refused).retry_after_ms, 0U);
  EXPECT_LT(appended, 70U);  // of a mebibyte each, where 64 may wait
  store_.SetStalled(false);
  store_->Flush();
  EXPECT_EQ(answered, appended - 1);
  EXPECT_OK(store_->Admit());
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.lsn(), appended);
}

INSTANTIATE_TEST_SUITE_P(Stores, StoreFailures,
                         ::testing::ValuesIn(WithPostgres({"memory", "sqlite"})),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
