// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What store.h promises, for every store.
#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/store.h"
#include "tests/server/store/opened_store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class StoreSuite : public ::testing::TestWithParam<std::string> {
 protected:
  // Records lsn … lsn + count - 1 of a scene, "gear 7", each in its turn.
  void Fill(const std::string& scene, uint64_t lsn, uint64_t count) {
    for (uint64_t i = 0; i < count; ++i) {
      store_->Append(scene, lsn + i, scene + " " + std::to_string(lsn + i), nullptr);
    }
    ASSERT_OK(store_.Barrier(scene));
  }

  OpenedStore store_{GetParam()};
};

TEST_P(StoreSuite, ReadsBackWhatWasAppended) {
  ASSERT_OK(store_->CreateScene("gear", "a header"));
  const std::string with_zeros("\0 1 \xFF", 5);

  ASSERT_OK(store_.Append("gear", 1, "first"));
  ASSERT_OK(store_.Append("gear", 2, with_zeros));
  ASSERT_OK(store_.Append("gear", 3, ""));

  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.header, "a header");
  EXPECT_EQ(log.snapshot_lsn, 0U);
  EXPECT_EQ(log.snapshot, "");
  EXPECT_THAT(log.records, ElementsAre("first", with_zeros, ""));
  EXPECT_EQ(log.lsn(), 3U);
}

TEST_P(StoreSuite, KeepsScenesApart) {
  ASSERT_OK(store_->CreateScene("a", "header of a"));
  ASSERT_OK(store_->CreateScene("b", "header of b"));
  for (uint64_t lsn = 1; lsn <= 3; ++lsn) {
    Fill("a", lsn, 1);
    if (lsn < 3) Fill("b", lsn, 1);
  }

  ASSERT_OK_AND_ASSIGN(const SceneLog a, store_->ReadScene("a"));
  ASSERT_OK_AND_ASSIGN(const SceneLog b, store_->ReadScene("b"));
  EXPECT_THAT(a.records, ElementsAre("a 1", "a 2", "a 3"));
  EXPECT_THAT(b.records, ElementsAre("b 1", "b 2"));
}

TEST_P(StoreSuite, ListsScenesInOrderOfTheirIds) {
  for (const std::string id : {"b", "a", "c"}) ASSERT_OK(store_->CreateScene(id, "header " + id));
  ASSERT_OK(store_->DeleteScene("c"));

  ASSERT_OK_AND_ASSIGN(const std::vector<StoredEntry> scenes, store_->Scenes());

  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_EQ(scenes[0].id, "a");
  EXPECT_EQ(scenes[0].header, "header a");
  EXPECT_OK(scenes[0].damage);
  EXPECT_EQ(scenes[1].id, "b");
}

TEST_P(StoreSuite, NamesWhatIsTakenOrMissing) {
  ASSERT_OK(store_->CreateScene("gear", ""));

  EXPECT_THAT(store_->CreateScene("gear", ""),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr("'gear'")));
  EXPECT_THAT(store_->ReadScene("knot"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("'knot'")));
  EXPECT_THAT(store_->DeleteScene("knot"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(store_.Append("knot", 1, "x"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(store_.Barrier("knot"), StatusIs(absl::StatusCode::kNotFound));
  ASSERT_OK(store_.Append("gear", 1, "x"));
}

TEST_P(StoreSuite, ReadsHeadersAlone) {
  const std::string mesh = Sha256Hex("bytes");
  ASSERT_OK(store_->PutMesh(mesh, "of a mesh", "bytes"));
  ASSERT_OK(store_->CreateScene("gear", "of a gear"));

  ASSERT_OK_AND_ASSIGN(const std::string of_scene, store_->ReadSceneHeader("gear"));
  ASSERT_OK_AND_ASSIGN(const std::string of_mesh, store_->ReadMeshHeader(mesh));
  EXPECT_EQ(of_scene, "of a gear");
  EXPECT_EQ(of_mesh, "of a mesh");
  EXPECT_THAT(store_->ReadSceneHeader("knot"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("'knot'")));
  EXPECT_THAT(store_->ReadMeshHeader("of nothing"), StatusIs(absl::StatusCode::kNotFound));
}

TEST_P(StoreSuite, OwnsWhatItCreatedAndClaimed) {
  ASSERT_OK(store_->CreateScene("gear", ""));
  ASSERT_OK(store_.Append("gear", 1, "first"));

  ASSERT_OK_AND_ASSIGN(const SceneClaim claim, store_->ClaimScene("gear"));
  EXPECT_EQ(claim.owner, "");
  ASSERT_OK(store_.Append("gear", 2, "second"));
  ASSERT_OK(store_->ReleaseScene("gear"));
  ASSERT_OK_AND_ASSIGN(const SceneClaim again, store_->ClaimScene("gear"));
  EXPECT_EQ(again.owner, "");
  ASSERT_OK(store_->ReadScene("gear").status());
  ASSERT_OK(store_.Append("gear", 3, "third"));
  EXPECT_THAT(store_->ClaimScene("knot"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_OK(store_->ReleaseScene("knot"));
}

TEST_P(StoreSuite, ASceneMayBeginWithASnapshot) {
  ASSERT_OK(store_->CreateSceneAt("gear", "of a gear", 7, "seven records"));
  EXPECT_THAT(store_->CreateSceneAt("gear", "another", 3, "three"),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr("'gear'")));

  ASSERT_OK_AND_ASSIGN(const SceneLog made, store_->ReadScene("gear"));
  EXPECT_EQ(made.header, "of a gear");
  EXPECT_EQ(made.snapshot, "seven records");
  EXPECT_EQ(made.lsn(), 7U);
  ASSERT_OK(store_.Append("gear", 8, "eight"));
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.snapshot_lsn, 7U);
  EXPECT_THAT(log.records, ElementsAre("eight"));
  EXPECT_THAT(store_.Append("gear", 8, "again"), StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST_P(StoreSuite, ACopyIsWhatIsDurableAndMendsNothing) {
  ASSERT_OK(store_->CreateScene("gear", "of a gear"));
  Fill("gear", 1, 3);
  EXPECT_THAT(store_.Append("gear", 9, "not the next"),
              StatusIs(absl::StatusCode::kFailedPrecondition));

  ASSERT_OK_AND_ASSIGN(const SceneLog copy, store_->CopyScene("gear"));
  EXPECT_EQ(copy.header, "of a gear");
  EXPECT_THAT(copy.records, ElementsAre("gear 1", "gear 2", "gear 3"));
  EXPECT_THAT(store_.Append("gear", 4, "x"), StatusIs(absl::StatusCode::kFailedPrecondition));
  ASSERT_OK(store_->ReadScene("gear").status());
  EXPECT_OK(store_.Append("gear", 4, "x"));
  EXPECT_THAT(store_->CopyScene("knot"), StatusIs(absl::StatusCode::kNotFound));
}

TEST_P(StoreSuite, AnswersInTheOrderOfTheCalls) {
  ASSERT_OK(store_->CreateScene("gear", ""));
  constexpr uint64_t kRecords = 500;
  std::mutex mutex;
  std::vector<uint64_t> answered;
  const auto note = [&](uint64_t what) {
    return [&, what](const absl::Status& status) {
      const std::lock_guard lock(mutex);
      EXPECT_OK(status);
      answered.push_back(what);
    };
  };

  for (uint64_t lsn = 1; lsn <= kRecords; ++lsn) {
    store_->Append("gear", lsn, "x", note(2 * lsn));
    store_->Append("gear", 0, "", note(2 * lsn + 1));
  }
  ASSERT_OK(store_.Barrier("gear"));

  const std::lock_guard lock(mutex);
  ASSERT_EQ(answered.size(), 2 * kRecords);
  for (uint64_t i = 0; i < answered.size(); ++i) EXPECT_EQ(answered[i], i + 2);
}

TEST_P(StoreSuite, FlushWaitsForAllAnswers) {
  ASSERT_OK(store_->CreateScene("gear", ""));
  std::atomic<int> answered = 0;
  for (uint64_t lsn = 1; lsn <= 100; ++lsn) {
    store_->Append("gear", lsn, "x", [&](const absl::Status&) { ++answered; });
  }

  store_->Flush();

  EXPECT_EQ(answered, 100);
}

TEST_P(StoreSuite, DoneMayAppend) {
  ASSERT_OK(store_->CreateScene("gear", ""));
  std::promise<absl::Status> second;

  store_->Append("gear", 1, "first", [&](const absl::Status&) {
    store_->Append("gear", 2, "second",
                   [&](const absl::Status& status) { second.set_value(status); });
  });

  EXPECT_OK(second.get_future().get());
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_THAT(log.records, ElementsAre("first", "second"));
}

TEST_P(StoreSuite, ASnapshotStandsForTheRecordsBeforeIt) {
  ASSERT_OK(store_->CreateScene("gear", "header"));
  Fill("gear", 1, 5);

  store_->PutSnapshot("gear", 3, "state 3");
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.snapshot_lsn, 3U);
  EXPECT_EQ(log.snapshot, "state 3");
  EXPECT_THAT(log.records, ElementsAre("gear 4", "gear 5"));

  store_->PutSnapshot("gear", 5, "state 5");
  Fill("gear", 6, 1);
  ASSERT_OK_AND_ASSIGN(const SceneLog later, store_->ReadScene("gear"));
  EXPECT_EQ(later.snapshot, "state 5");
  EXPECT_THAT(later.records, ElementsAre("gear 6"));
  EXPECT_EQ(later.header, "header");
}

TEST_P(StoreSuite, IgnoresSnapshotsOfOtherStates) {
  ASSERT_OK(store_->CreateScene("gear", ""));
  Fill("gear", 1, 3);
  store_->PutSnapshot("gear", 2, "state 2");

  store_->PutSnapshot("gear", 1, "older");
  store_->PutSnapshot("gear", 4, "of the future");
  store_->PutSnapshot("knot", 1, "of nothing");

  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.snapshot, "state 2");
  EXPECT_THAT(log.records, ElementsAre("gear 3"));
}

TEST_P(StoreSuite, ADeletedSceneLeavesNothingToItsNextOne) {
  ASSERT_OK(store_->CreateScene("gear", "old"));
  Fill("gear", 1, 3);
  store_->PutSnapshot("gear", 2, "state 2");
  ASSERT_OK(store_->DeleteScene("gear"));
  EXPECT_THAT(store_->ReadScene("gear"), StatusIs(absl::StatusCode::kNotFound));

  ASSERT_OK(store_->CreateScene("gear", "new"));
  ASSERT_OK(store_.Append("gear", 1, "new record"));

  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.header, "new");
  EXPECT_EQ(log.snapshot_lsn, 0U);
  EXPECT_THAT(log.records, ElementsAre("new record"));
}

TEST_P(StoreSuite, KeepsSharesAsLongAsTheirScene) {
  for (const std::string scene : {"gear", "knot"}) ASSERT_OK(store_->CreateScene(scene, ""));
  ASSERT_OK(store_->PutShare("b", "gear", "for readers"));
  ASSERT_OK(store_->PutShare("a", "knot", std::string("\0 1", 3)));
  ASSERT_OK(store_->PutShare("c", "gear", "of another header"));
  ASSERT_OK(store_->PutShare("c", "gear", "for editors"));
  ASSERT_OK(store_->DeleteShare("nothing"));
  EXPECT_THAT(store_->PutShare("d", "vase", ""),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("'vase'")));

  const auto shares = [this] {
    const std::vector<StoredEntry> stored = store_->Shares().value();
    std::vector<std::string> all;
    for (const StoredEntry& share : stored) {
      EXPECT_OK(share.damage);
      all.push_back(share.id + ": " + share.header);
    }
    return all;
  };
  EXPECT_THAT(shares(), ElementsAre(std::string("a: \0 1", 6), "b: for readers", "c: for editors"));
  ASSERT_OK_AND_ASSIGN(const std::string mark, store_->SharesMark());
  EXPECT_EQ(*store_->SharesMark(), mark);
  ASSERT_OK(store_->DeleteShare("b"));
  EXPECT_TRUE(mark.empty() || *store_->SharesMark() != mark);
  EXPECT_THAT(shares(), ElementsAre(std::string("a: \0 1", 6), "c: for editors"));
  ASSERT_OK(store_->DeleteScene("gear"));
  ASSERT_OK(store_->CreateScene("gear", ""));
  EXPECT_THAT(shares(), ElementsAre(std::string("a: \0 1", 6)));
}

TEST_P(StoreSuite, AMeshIsKeptOnce) {
  const std::string bytes("v 0 0 0\n\0", 9);
  const std::string id = Sha256Hex(bytes);

  ASSERT_OK(store_->PutMesh(id, "header", bytes));
  ASSERT_OK(store_->PutMesh(id, "another header", bytes));

  ASSERT_OK_AND_ASSIGN(const std::string read, store_->ReadMesh(id));
  EXPECT_EQ(read, bytes);
  ASSERT_OK_AND_ASSIGN(const std::vector<StoredEntry> meshes, store_->Meshes());
  ASSERT_EQ(meshes.size(), 1U);
  EXPECT_EQ(meshes[0].id, id);
  EXPECT_EQ(meshes[0].header, "header");
}

TEST_P(StoreSuite, ADeletedMeshIsGone) {
  const std::string id = Sha256Hex("bytes");
  ASSERT_OK(store_->PutMesh(id, "header", "bytes"));

  ASSERT_OK(store_->DeleteMesh(id));

  EXPECT_THAT(store_->ReadMesh(id), StatusIs(absl::StatusCode::kNotFound, HasSubstr(id)));
  EXPECT_THAT(store_->DeleteMesh(id), StatusIs(absl::StatusCode::kNotFound));
  ASSERT_OK_AND_ASSIGN(const std::vector<StoredEntry> meshes, store_->Meshes());
  EXPECT_THAT(meshes, IsEmpty());
  ASSERT_OK(store_->PutMesh(id, "header", "bytes"));
  EXPECT_OK(store_->ReadMesh(id));
}

// Stores that outlive the process.
class DurableStoreSuite : public StoreSuite {};

TEST_P(DurableStoreSuite, KeepsEverythingWhenItIsOpenedAgain) {
  const std::string mesh = Sha256Hex("bytes");
  ASSERT_OK(store_->PutMesh(mesh, "of a mesh", "bytes"));
  ASSERT_OK(store_->CreateScene("gear", "header"));
  ASSERT_OK(store_->CreateScene("knot", "header of knot"));
  ASSERT_OK(store_->CreateScene("gone", ""));
  Fill("gear", 1, 4);
  Fill("knot", 1, 2);
  store_->PutSnapshot("gear", 3, "state 3");
  ASSERT_OK(store_->DeleteScene("gone"));

  const auto claim_and_read = [&](const std::string& scene) {
    EXPECT_OK(store_->ClaimScene(scene).status());
    return store_->ReadScene(scene);
  };
  store_.Reopen();
  ASSERT_OK(claim_and_read("gear").status());
  ASSERT_OK(store_.Append("gear", 5, "gear 5"));
  store_.Reopen();

  ASSERT_OK_AND_ASSIGN(const SceneLog gear, claim_and_read("gear"));
  EXPECT_EQ(gear.snapshot, "state 3");
  EXPECT_THAT(gear.records, ElementsAre("gear 4", "gear 5"));
  ASSERT_OK_AND_ASSIGN(const SceneLog knot, claim_and_read("knot"));
  EXPECT_EQ(knot.header, "header of knot");
  EXPECT_THAT(knot.records, ElementsAre("knot 1", "knot 2"));
  ASSERT_OK_AND_ASSIGN(const std::vector<StoredEntry> scenes, store_->Scenes());
  EXPECT_EQ(scenes.size(), 2U);
  ASSERT_OK_AND_ASSIGN(const std::string bytes, store_->ReadMesh(mesh));
  EXPECT_EQ(bytes, "bytes");
}

INSTANTIATE_TEST_SUITE_P(Stores, StoreSuite,
                         ::testing::ValuesIn(WithPostgres({"memory", "shared_memory", "sqlite"})),
                         [](const auto& info) { return info.param; });
INSTANTIATE_TEST_SUITE_P(Stores, DurableStoreSuite, ::testing::ValuesIn(WithPostgres({"sqlite"})),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
