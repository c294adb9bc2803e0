// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Random calls to a store in a folder and to one in memory, which is simple enough to be right: every answer and all that
// is read must be equal. The medium fails at times, and the folder is opened anew.
#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <string>

#include "fmt/format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/store.h"
#include "tests/server/store/opened_store.h"
#include "tests/support/seed.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr int kSessions = 5;
constexpr int kCalls = 600;
constexpr int kScenes = 5;

class StoreModel : public ::testing::Test {
 protected:
  int Below(int end) { return static_cast<int>(random_() % static_cast<unsigned>(end)); }
  std::string Bytes() {
    return std::string(static_cast<size_t>(Below(Below(10) == 0 ? 20'000 : 500)), 'b') +
           fmt::to_string(++unique_);
  }

  void Step() {
    const std::string id = fmt::format("scene {}", Below(kScenes));
    const int kind = Below(100);
    if (kind < 60) {
      AppendSome(id);
    } else if (kind < 70) {
      Snapshot(id);
    } else if (kind < 82) {
      Compare(id);
    } else if (kind < 88) {
      Same(id, [&](Store& store) { return store.CreateScene(id, "header " + id); });
    } else if (kind < 91) {
      Same(id, [&](Store& store) { return store.DeleteScene(id); });
      next_.erase(id);
    } else if (kind < 93) {
      Fail(id);
    } else if (kind < 95) {
      sqlite_.Reopen();
      for (int i = 0; i < kScenes; ++i) Compare(fmt::format("scene {}", i));
    } else {
      Same(id, [&](Store& store) { return store.Admit(); });
    }
  }

  template <typename Call>
  void Same(const std::string& id, Call call) {
    const absl::Status expected = call(*memory_);
    EXPECT_EQ(call(*sqlite_).code(), expected.code()) << id << ": " << expected;
  }

  // Mostly the next records; one in `wrong_of` is another one.
  void AppendSome(const std::string& id, int wrong_of = 60) {
    const int count = 1 + Below(20);
    for (int i = 0; i < count; ++i) {
      const uint64_t lsn = Below(wrong_of) == 0 ? next_[id] + 2 : ++next_[id];
      const std::string record = Bytes();
      if (i + 1 < count) {
        memory_->Append(id, lsn, record, nullptr);
        sqlite_->Append(id, lsn, record, nullptr);
      } else {
        EXPECT_EQ(sqlite_.Append(id, lsn, record).code(), memory_.Append(id, lsn, record).code());
      }
    }
    EXPECT_EQ(sqlite_.Barrier(id).code(), memory_.Barrier(id).code());
  }

  void Snapshot(const std::string& id) {
    const uint64_t lsn =
        next_[id] - std::min<uint64_t>(next_[id], static_cast<uint64_t>(Below(10)));
    const std::string state = Bytes();
    memory_->PutSnapshot(id, lsn, state);
    sqlite_->PutSnapshot(id, lsn, state);
  }

  void Fail(const std::string& id) {
    memory_->Flush();
    sqlite_->Flush();
    memory_.SetFull(true);
    AppendSome(id, 1'000'000'000);  // two reasons to refuse: either may be told
    memory_.SetFull(false);
    ASSERT_TRUE(sqlite_.AdmitsAgain());
  }

  void Compare(const std::string& id) {
    const auto expected = memory_->ReadScene(id);
    const auto read = sqlite_->ReadScene(id);
    ASSERT_EQ(read.status().code(), expected.status().code()) << id;
    next_[id] = 0;
    if (!expected.ok()) return;
    EXPECT_EQ(read->header, expected->header);
    EXPECT_EQ(read->snapshot_lsn, expected->snapshot_lsn);
    EXPECT_TRUE(read->snapshot == expected->snapshot) << id;
    EXPECT_TRUE(read->records == expected->records)
        << id << ": " << read->records.size() << " records, not " << expected->records.size();
    next_[id] = expected->lsn();
  }

  OpenedStore memory_{"memory"};
  OpenedStore sqlite_{"sqlite"};
  std::map<std::string, uint64_t> next_;  // the last lsn that was appended
  std::mt19937 random_;
  int unique_ = 0;
};

TEST_F(StoreModel, AnswersAsOneInMemory) {
  const uint32_t first = SeedOr(1);
  for (unsigned seed = first; seed < first + kSessions && !HasFailure(); ++seed) {
    SCOPED_TRACE(fmt::format("LATTICED_SEED={}", seed));
    random_.seed(seed);
    for (int i = 0; i < kCalls && !HasFailure(); ++i) Step();
    for (int i = 0; i < kScenes; ++i) Compare(fmt::format("scene {}", i));
  }
}

}  // namespace
}  // namespace latticed::testing
