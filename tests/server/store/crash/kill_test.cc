// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server that is killed at a random instant loses nothing that it acknowledged, with full and with async durability.
#include <random>
#include <string>

#include "gtest/gtest.h"
#include "server/store/sqlite_store.h"
#include "tests/server/store/crash/lost_records.h"
#include "tests/server/store/crash/numbered_records.h"
#include "tests/server/store/crash/running_child.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr int kKills = 200;

class StoreKill : public ::testing::TestWithParam<std::string> {};

TEST_P(StoreKill, LosesNothing) {
  const TemporaryFolder folder;
  const std::string data = folder.Path("data");
  std::mt19937 random(23);
  for (int kill = 0; kill < Faults(kKills); ++kill) {
    SCOPED_TRACE(kill);
    RunningChild child(data, GetParam(), 60);
    ASSERT_TRUE(child.Work(absl::Milliseconds(random() % 200)));
    child.Kill();

    ASSERT_OK_AND_ASSIGN(const auto store, OpenSqliteStore({.folder = data}));
    EXPECT_EQ(LostOf(child.acknowledged(), *store), 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Durability, StoreKill, ::testing::Values("full", "async"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
