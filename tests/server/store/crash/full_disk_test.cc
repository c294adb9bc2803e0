// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A disk that is really full: a small filesystem in memory, with a file that takes room until the test removes it.
#include <fcntl.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <string>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/sqlite_store.h"
#include "tests/server/store/crash/numbered_records.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class StoreFullDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(disk_);
    if (mount("none", disk_.c_str(), "tmpfs", 0, "size=48m") != 0) {
      GTEST_SKIP() << "no filesystem can be mounted here";
    }
    mounted_ = true;
  }
  void TearDown() override {
    store_.reset();
    if (mounted_) umount(disk_.c_str());
  }

  absl::Status Open() {
    store_.reset();
    auto opened = OpenSqliteStore({.folder = disk_ + "/data"});
    if (opened.ok()) store_ = *std::move(opened);
    return opened.status();
  }

  // Takes so much room, as far as there is any.
  void Take(size_t bytes) const {
    const std::string page(4'096, 't');
    const int file = open((disk_ + "/taken").c_str(), O_WRONLY | O_CREAT, 0600);
    for (size_t taken = 0; taken < bytes; taken += page.size()) {
      if (write(file, page.data(), page.size()) < 0) break;
    }
    close(file);
  }
  void GiveBack() const { std::filesystem::remove(disk_ + "/taken"); }

  absl::Status Append(const std::string& scene, uint64_t lsn) {
    const auto answer = std::make_shared<std::promise<absl::Status>>();
    store_->Append(scene, lsn, RecordOf(scene, lsn),
                   [answer](const absl::Status& status) { answer->set_value(status); });
    return answer->get_future().get();
  }

  // Appends until it is refused, and returns the last acknowledged record.
  uint64_t Fill(const std::string& scene, uint64_t lsn) {
    while ((refused_ = Append(scene, lsn + 1)).ok()) ++lsn;
    return lsn;
  }

  void ExpectStored(const std::string& scene, uint64_t lsn) {
    ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene(scene));
    EXPECT_EQ(log.lsn(), lsn);
    EXPECT_EQ(WrongIn(log, scene), "");
  }

  bool AdmitsAgain() {
    for (int i = 0; i < 2'000 && !store_->Admit().ok(); ++i) absl::SleepFor(absl::Milliseconds(10));
    return store_->Admit().ok();
  }

  const TemporaryFolder folder_;
  const std::string disk_ = folder_.Path("disk");
  bool mounted_ = false;
  std::unique_ptr<Store> store_;
  absl::Status refused_;
};

TEST_F(StoreFullDisk, RefusesEditsAndGoesOnWhenThereIsRoom) {
  Take(24 << 20);
  ASSERT_OK(Open());
  for (const std::string scene : {"gear", "knot"}) {
    ASSERT_OK(store_->CreateScene(scene, HeaderOf(scene)));
  }

  const uint64_t stored = Fill("gear", 0);

  EXPECT_THAT(refused_, StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("no room")));
  EXPECT_EQ(error::DetailsOf(refused_).reason, "STORE");
  EXPECT_GT(stored, 1'000U);
  EXPECT_THAT(store_->Admit(), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(Append("knot", 1), StatusIs(absl::StatusCode::kResourceExhausted));
  ExpectStored("gear", stored);
  ExpectStored("knot", 0);

  GiveBack();
  ASSERT_TRUE(AdmitsAgain());
  ASSERT_OK(Append("gear", stored + 1));
  ASSERT_OK(Append("knot", 1));
  ASSERT_OK(Open());
  ExpectStored("gear", stored + 1);
  ExpectStored("knot", 1);
}

TEST_F(StoreFullDisk, LosesNothingWhenItIsOpenedWithoutRoom) {
  ASSERT_OK(Open());
  ASSERT_OK(store_->CreateScene("gear", HeaderOf("gear")));
  for (uint64_t lsn = 1; lsn <= 1'000; ++lsn) ASSERT_OK(Append("gear", lsn));
  store_.reset();
  Take(48 << 20);

  const absl::Status opened = Open();

  if (!opened.ok()) {
    EXPECT_THAT(opened,
                StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("latticed.sqlite")));
    GiveBack();
    ASSERT_OK(Open());
  }
  ExpectStored("gear", 1'000);
}

TEST_F(StoreFullDisk, AMeshThatDoesNotFitIsRefused) {
  ASSERT_OK(Open());
  const std::string bytes(40 << 20, 'm');
  const std::string more(20 << 20, 'm');
  const std::string id = Sha256Hex(bytes);

  ASSERT_OK(store_->PutMesh(id, "", bytes));
  EXPECT_THAT(store_->PutMesh(Sha256Hex(more), "", more),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("no room")));
  EXPECT_THAT(store_->ReadMesh(Sha256Hex(more)), StatusIs(absl::StatusCode::kNotFound));
  ASSERT_OK(store_->DeleteMesh(id));

  EXPECT_OK(store_->PutMesh(Sha256Hex(more), "", more));
}

}  // namespace
}  // namespace latticed::testing
