// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who is at a scene, and what of that a watcher has not been told yet.           WIRE.md "presence"
//
//   stream of an editor -> PresenceBoard::Show, Leave -> PresenceFeed::Next of every other stream
//
// The board holds the newest of each editor and nothing else. A feed compares it with what it has
// told, so that there is no queue, a slow reader skips what is old, one who comes late is told of
// all who are there, and no leaving is missed. Of one editor it tells at most
// limits::kMaxPresencesPerSecond, but that he left at once.
//
// Errors   none
// Threads  the board is safe; a feed belongs to its stream, which locks
#ifndef LATTICED_SERVER_ENGINE_PRESENCE_H_
#define LATTICED_SERVER_ENGINE_PRESENCE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "server/base/mutex.h"

namespace latticed {

struct Presence {
  std::string editor_id;
  std::string name;
  uint32_t colour = 0;  // 0xRRGGBB
  std::vector<uint32_t> selected;
  bool left = false;  // the rest is empty then
};

class PresenceBoard {
 public:
  // Of which stream a presence is.
  using Owner = const void*;

  // Takes the place of what the editor showed before, through whichever stream.
  void Show(Owner owner, Presence presence) ABSL_LOCKS_EXCLUDED(mutex_);
  // The editors whom no other stream shows have left. Whether there are any.
  bool Leave(Owner owner) ABSL_LOCKS_EXCLUDED(mutex_);

  struct Entry {
    std::shared_ptr<const Presence> presence;
    uint64_t version = 0;  // rises with all that is shown
  };
  // By editor, where something has changed since `version`, which becomes that of the result.
  [[nodiscard]] std::optional<std::map<std::string, Entry>> NewsSince(uint64_t& version) const
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  mutable Mutex mutex_;
  uint64_t version_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::set<Owner>> owners_ ABSL_GUARDED_BY(mutex_);
};

class PresenceFeed {
 public:
  // Tells nothing of `own_editor`. The board outlives the feed.
  PresenceFeed(const PresenceBoard* board, std::string own_editor)
      : board_(board), own_editor_(std::move(own_editor)) {}

  // What to tell next; null when there is nothing, or nothing before wake_at().
  [[nodiscard]] std::shared_ptr<const Presence> Next(absl::Time now);
  // InfiniteFuture where time changes nothing.
  absl::Time wake_at() const { return wake_at_; }

 private:
  struct Told {
    uint64_t version = 0;
    absl::Time time;
  };

  const PresenceBoard* const board_;
  const std::string own_editor_;
  uint64_t version_ = 0;                               // of there_
  std::map<std::string, PresenceBoard::Entry> there_;  // as of the last look
  std::map<std::string, Told> told_;                   // of editors who were there when told
  absl::Time wake_at_ = absl::InfiniteFuture();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_PRESENCE_H_
