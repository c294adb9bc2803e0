// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A bit that flips, or an end that is cut off, at random places of a store's files. The store must say kDataLoss (or,
// where its very header is hit, whose file it is not), or give back exactly what was written. What is cut off the log
// of a server that was killed is as if the server had been killed earlier: all scenes end at one commit before.
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "server/store/sqlite_store.h"
#include "tests/server/store/crash/numbered_records.h"
#include "tests/server/store/crash/running_child.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr int kDamages = 1'000;
constexpr int kScenes = 12;

bool IsTold(const absl::Status& status) {
  return absl::IsDataLoss(status) || absl::IsFailedPrecondition(status);
}

class StoreDamage : public ::testing::Test {
 protected:
  // A folder of a server that was killed, with a log, and one of a server that ended, without.
  void SetUp() override {
    for (const absl::Duration time : {absl::Milliseconds(100), absl::Milliseconds(400)}) {
      // Opened, a store puts its log into the database, so all scenes are there before the log that is cut.
      if (std::filesystem::exists(Killed())) {
        ASSERT_OK(OpenSqliteStore({.folder = Killed()}));
      }
      RunningChild child(Killed(), "full", kScenes);
      ASSERT_TRUE(child.Work(time));
      child.Kill();
    }
    std::filesystem::copy(Killed(), Ended(), std::filesystem::copy_options::recursive);
    ASSERT_OK_AND_ASSIGN(const auto store, OpenSqliteStore({.folder = Ended()}));
    for (int i = 0; i < kScenes; ++i) {
      const std::string scene = fmt::format("s{}", i);
      ASSERT_OK_AND_ASSIGN(const SceneLog log, store->ReadScene(scene));
      ASSERT_EQ(WrongIn(log, scene), "");
      lsn_[scene] = log.lsn();
    }
  }

  std::string Killed() const { return folder_.Path("killed"); }
  std::string Ended() const { return folder_.Path("ended"); }

  // Copies `original`, damages `file` of the copy, and reads all of it. Returns how many records fewer than before were
  // read although nothing was told.
  uint64_t Lost(const std::string& original, const std::string& file,
                const std::function<void(const std::string&)>& damage) {
    const std::string copy = folder_.Path("copy");
    std::filesystem::remove_all(copy);
    std::filesystem::copy(original, copy, std::filesystem::copy_options::recursive);
    damage(copy + "/" + file);
    const auto store = OpenSqliteStore({.folder = copy});
    if (!store.ok()) {
      EXPECT_TRUE(IsTold(store.status())) << store.status();
      ++told_;
      return 0;
    }
    return LostScenes(**store);
  }

  uint64_t LostScenes(Store& store) {
    uint64_t lost = 0;
    const auto scenes = store.Scenes();
    if (scenes.ok()) {
      EXPECT_EQ(scenes->size(), lsn_.size());
    } else {
      EXPECT_TRUE(IsTold(scenes.status())) << scenes.status();
      ++told_;
    }
    for (const auto& [scene, lsn] : lsn_) {
      const auto log = store.ReadScene(scene);
      if (log.ok()) {
        EXPECT_EQ(WrongIn(*log, scene), "");
        EXPECT_LE(log->lsn(), lsn);
        lost += lsn - log->lsn();
      } else {
        EXPECT_TRUE(IsTold(log.status())) << log.status();
        ++told_;
      }
    }
    return lost;
  }

  static void FlipBit(const std::string& path, uint64_t place) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    const auto at = static_cast<std::streamoff>(place / 8 % std::filesystem::file_size(path));
    file.seekg(at);
    const char byte = static_cast<char>(file.get() ^ (1 << place % 8));
    file.seekp(at);
    file.put(byte);
  }

  static void Cut(const std::string& path, uint64_t place) {
    std::filesystem::resize_file(path, place % std::filesystem::file_size(path));
  }

  TemporaryFolder folder_;
  std::map<std::string, uint64_t> lsn_;
  int told_ = 0;
  std::mt19937_64 random_{23};
};

TEST_F(StoreDamage, AFlippedBitOfTheDatabaseIsTold) {
  for (int i = 0; i < Faults(kDamages); ++i) {
    const uint64_t place = random_();
    SCOPED_TRACE(place);
    EXPECT_EQ(
        Lost(Ended(), "latticed.sqlite", [&](const std::string& path) { FlipBit(path, place); }),
        0U);
  }
  EXPECT_GT(told_, 0);
}

// A page with another number of rows is a page to SQLite. It would lack rows, and nothing in the others would say so.
TEST_F(StoreDamage, APageThatHidesRowsIsTold) {
  constexpr uint64_t kPageBytes = 4'096;
  constexpr uint64_t kRowCountAt = 4;  // its lower byte
  const uint64_t pages = std::filesystem::file_size(Ended() + "/latticed.sqlite") / kPageBytes;
  for (int i = 0; i < Faults(kDamages); ++i) {
    const uint64_t page = i == 0 ? pages - 1 : 1 + random_() % (pages - 1);
    const uint64_t place = (page * kPageBytes + kRowCountAt) * 8 + random_() % 3;
    SCOPED_TRACE(page);
    const auto flip = [&](const std::string& path) { FlipBit(path, place); };
    EXPECT_EQ(Lost(Ended(), "latticed.sqlite", flip), 0U);
  }
  EXPECT_GT(told_, 0);
}

TEST_F(StoreDamage, ACutDatabaseIsTold) {
  for (int i = 0; i < Faults(kDamages); ++i) {
    const uint64_t place = random_();
    SCOPED_TRACE(place);
    EXPECT_EQ(Lost(Ended(), "latticed.sqlite", [&](const std::string& path) { Cut(path, place); }),
              0U);
  }
  EXPECT_GT(told_, 0);
}

// SQLite takes a damaged frame for the end of the log. Only the last two commits may go that way: wal_check.h.
TEST_F(StoreDamage, AFlippedBitOfTheLogIsToldUnlessItIsInTheLastCommits) {
  const uint64_t size = std::filesystem::file_size(Killed() + "/latticed.sqlite-wal");
  ASSERT_GT(size, 100'000U);
  for (int i = 0; i < Faults(kDamages); ++i) {
    const uint64_t place = random_();
    SCOPED_TRACE(place);
    const uint64_t lost = Lost(Killed(), "latticed.sqlite-wal",
                               [&](const std::string& path) { FlipBit(path, place); });
    EXPECT_LE(lost,
              2U * kScenes *
                  2U);  // two commits: store_child.cc has at most two records of a scene in one
  }
  EXPECT_GT(told_, 0);
}

TEST_F(StoreDamage, ACutLogEndsAtACommit) {
  for (int i = 0; i < Faults(kDamages); ++i) {
    const uint64_t place = random_();
    SCOPED_TRACE(place);
    Lost(Killed(), "latticed.sqlite-wal", [&](const std::string& path) { Cut(path, place); });
  }
}

TEST_F(StoreDamage, ADamagedIndexOfTheLogIsMadeAnew) {
  for (int i = 0; i < Faults(kDamages) / 10; ++i) {
    const uint64_t place = random_();
    SCOPED_TRACE(place);
    EXPECT_EQ(Lost(Killed(), "latticed.sqlite-shm",
                   [&](const std::string& path) { FlipBit(path, place); }),
              0U);
  }
  EXPECT_EQ(told_, 0);
}

}  // namespace
}  // namespace latticed::testing
