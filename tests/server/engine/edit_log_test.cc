// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/edit_log.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace latticed {
namespace {

// Adds the edit that made `revision`. Its sequence number is `revision` as well.
void Add(EditLog& log, uint64_t revision, size_t points, const std::string& editor = "alice") {
  auto delta = std::make_shared<LatticeDelta>();
  delta->revision = delta->sequence = revision;
  delta->editor_id = editor;
  delta->indices.resize(points);
  delta->positions.resize(points);
  log.Add(delta, false);
}

EditLog FiveEdits() {
  EditLog log;
  for (uint64_t revision = 1; revision <= 5; ++revision) Add(log, revision, 100);
  return log;
}

TEST(EditLog, TellsWhatCameAfterARevision) {
  const EditLog log = FiveEdits();
  EXPECT_TRUE(log.After(5, 5).deltas.empty());
  const EditLog::Deltas deltas = log.After(2, 5);
  EXPECT_TRUE(deltas.complete);
  ASSERT_EQ(deltas.deltas.size(), 3u);
  EXPECT_EQ(deltas.deltas.front()->revision, 3u);
  EXPECT_EQ(log.AppliedSequence("alice", 3), 3u);
  EXPECT_EQ(log.AppliedSequence("bob", 3), 0u);
}

// An editor who sends his edits again after a restart waits for an update that holds them.
TEST(EditLog, KnowsOfEditsBeforeARestart) {
  EditLog log;
  log.Remember("alice", 7, 5);
  EXPECT_EQ(log.AppliedSequence("alice", 4), 0u);
  EXPECT_EQ(log.AppliedSequence("alice", 5), 7u);
  EXPECT_FALSE(log.After(4, 5).complete);
}

TEST(EditLog, ForgetsPointsFirstAndThenWhoseTheyWere) {
  EditLog log = FiveEdits();
  const uint64_t bytes = log.MemoryBytes();

  ASSERT_TRUE(log.ForgetOldest());
  ASSERT_TRUE(log.ForgetOldest());

  EXPECT_EQ(log.MemoryBytes(), bytes - 2 * 100 * 28);
  EXPECT_FALSE(log.After(1, 5).complete);
  EXPECT_TRUE(log.After(2, 5).complete);
  EXPECT_EQ(log.AppliedSequence("alice", 1), 1u);
  ASSERT_TRUE(log.ForgetOldest());
  ASSERT_TRUE(log.ForgetOldest());
  EXPECT_EQ(log.AppliedSequence("alice", 1), 1u);
  ASSERT_TRUE(log.ForgetOldest());
  EXPECT_EQ(log.AppliedSequence("alice", 1), 0u);
}

TEST(EditLog, KeepsTheNewestEditAndItsEditor) {
  EditLog log = FiveEdits();
  Add(log, 6, 100, "bob");

  while (log.ForgetOldest()) continue;

  EXPECT_TRUE(log.After(5, 6).complete);
  EXPECT_EQ(log.AppliedSequence("bob", 6), 6u);
  EXPECT_EQ(log.AppliedSequence("alice", 6), 0u);
  Add(log, 7, 100);
  EXPECT_EQ(log.After(5, 7).deltas.size(), 2u);
}

TEST(EditLog, KnowsWhoseEditsWereOfWhichItHasNoPoints) {
  EditLog log;
  for (uint64_t revision = 1; revision <= 4; ++revision) Add(log, revision, 100'000);

  EXPECT_FALSE(log.After(1, 4).complete);
  EXPECT_TRUE(log.After(2, 4).complete);
  EXPECT_EQ(log.AppliedSequence("alice", 1), 1u);
}

}  // namespace
}  // namespace latticed
