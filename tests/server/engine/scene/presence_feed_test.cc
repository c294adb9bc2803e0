// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How often presence is told, by a clock of the test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/engine/scene.h"
#include "server/engine/scene/presence.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;

latticed::Presence Of(const std::string& editor, const std::string& name) {
  return {.editor_id = editor, .name = name};
}

// A stream that counts how often it is woken.
class CountingStream final : public SceneListener {
 public:
  void OnSceneChanged() override { ++wakes; }
  int wakes = 0;
};

// A board with three streams. The test chooses the time.
class PresenceFeedTest : public ::testing::Test {
 protected:
  struct Watching {
    Watching(PresenceBoard* board, const std::string& editor) : feed(board, editor) {}
    const std::shared_ptr<CountingStream> stream = std::make_shared<CountingStream>();
    PresenceFeed feed;

    std::shared_ptr<const latticed::Presence> Next(absl::Time now) {
      return feed.Next(now, stream);
    }
    // The names of all presences that are due.
    std::vector<std::string> All(absl::Time now) {
      std::vector<std::string> names;
      while (const auto told = Next(now)) names.push_back(told->name);
      return names;
    }
  };
  void Show(const Watching& by, const std::string& editor, const std::string& name) {
    Wake(board_.Show(by.stream.get(), Of(editor, name)));
  }

  const absl::Time start_ = absl::UnixEpoch();
  PresenceBoard board_;
  Watching alice_{&board_, "alice"}, bob_{&board_, "bob"}, carol_{&board_, "carol"};
};

TEST_F(PresenceFeedTest, TellsTheNewestAtMostTenTimesASecond) {
  Show(alice_, "alice", "0");
  EXPECT_EQ(bob_.Next(start_)->name, "0");
  EXPECT_EQ(bob_.Next(start_), nullptr);

  int told = 0;
  for (int ms = 1; ms <= 1000; ++ms) {
    const absl::Time now = start_ + absl::Milliseconds(ms);
    Show(alice_, "alice", std::to_string(ms));
    const auto presence = bob_.Next(now);
    if (presence == nullptr) {
      EXPECT_EQ(bob_.feed.wake_at(), start_ + absl::Milliseconds(100 * (told + 1)));
      continue;
    }
    ++told;
    EXPECT_EQ(presence->name, std::to_string(ms)) << "the newest, not the first that waited";
    EXPECT_EQ(bob_.Next(now), nullptr);
  }
  EXPECT_EQ(told, 10);
}

TEST_F(PresenceFeedTest, WhatOneShowsOneselfDelaysNothing) {
  EXPECT_EQ(bob_.Next(start_), nullptr);
  Show(bob_, "bob", "B");
  EXPECT_EQ(bob_.Next(start_), nullptr);
  Show(alice_, "alice", "A");
  EXPECT_EQ(bob_.stream->wakes, 2);
  EXPECT_EQ(bob_.Next(start_)->name, "A");
}

TEST_F(PresenceFeedTest, WhatIsShownDuringATurnIsOfTheNext) {
  Show(alice_, "alice", "A");
  Show(carol_, "carol", "C");
  EXPECT_EQ(bob_.Next(start_)->name, "A");
  // If this turn included A2, a slow reader would never hear of another editor.
  Show(alice_, "alice", "A2");
  EXPECT_EQ(bob_.Next(start_)->name, "C");
  Show(carol_, "carol", "C2");
  EXPECT_EQ(bob_.Next(start_), nullptr);
  EXPECT_EQ(bob_.feed.wake_at(), start_ + absl::Milliseconds(100));
  EXPECT_THAT(bob_.All(bob_.feed.wake_at()), ElementsAre("A2", "C2"));
}

TEST_F(PresenceFeedTest, NobodyIsToldOfHimselfAndAllOfWhoLeaves) {
  Show(alice_, "alice", "A");
  Show(bob_, "bob", "B");
  Show(carol_, "carol", "C");
  EXPECT_THAT(bob_.All(start_), ElementsAre("A", "C"));

  Show(alice_, "alice", "A2");
  Wake(board_.Leave(carol_.stream.get(), "carol"));
  const absl::Time then = bob_.feed.wake_at();
  const auto left = bob_.Next(then);
  ASSERT_NE(left, nullptr);
  EXPECT_EQ(left->editor_id, "carol");
  EXPECT_TRUE(left->left);
  EXPECT_THAT(bob_.All(then), ElementsAre("A2"));

  Wake(board_.Leave(alice_.stream.get(), "alice"));
  Show(alice_, "alice", "A3");
  EXPECT_THAT(bob_.All(bob_.feed.wake_at()), ElementsAre("A3")) << "came back before it was told";
}

TEST_F(PresenceFeedTest, AFloodWakesAStreamOnceATurn) {
  constexpr int kWatchers = 200, kShown = 5'000, kTurns = 10;
  std::vector<std::unique_ptr<Watching>> watchers;
  for (int i = 0; i < kWatchers; ++i) {
    watchers.push_back(std::make_unique<Watching>(&board_, std::to_string(i)));
    EXPECT_EQ(watchers.back()->Next(start_), nullptr);  // waits
  }
  absl::Time now = start_;
  for (int turn = 0; turn < kTurns; ++turn, now += absl::Milliseconds(200)) {
    for (int i = 0; i < kShown; ++i) Show(alice_, "alice", std::to_string(i));
    for (const auto& watcher : watchers) {
      EXPECT_EQ(watcher->stream->wakes, turn + 1);
      EXPECT_THAT(watcher->All(now), ElementsAre(std::to_string(kShown - 1)));
      EXPECT_EQ(watcher->Next(now + absl::Milliseconds(100)), nullptr);  // waits again
    }
  }
}

TEST_F(PresenceFeedTest, AStreamThatHasLeftIsNotWoken) {
  EXPECT_EQ(bob_.Next(start_), nullptr);
  EXPECT_TRUE(board_.Leave(bob_.stream.get(), "bob").empty()) << "he had shown nothing";
  Show(alice_, "alice", "A");
  EXPECT_EQ(bob_.stream->wakes, 0);
}

}  // namespace
}  // namespace latticed::testing
