// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who is at a scene, and what of that a watcher has not been told yet.          proto/README.md
//
//   stream of an editor -> PresenceBoard::Show, Leave -> PresenceFeed::Next of every other stream
//
// The board holds the newest presence of each editor and nothing else. Each watcher has a feed,
// which holds how far it has read. There is no queue: a slow reader skips what is old, a late one
// is told of everybody who is there, and nobody misses that an editor left.
//
// A feed works in turns. It tells all that was new when the turn began, and then nothing for a
// second / limits::kMaxPresencesPerSecond. Show wakes only the feeds that have read everything; a
// feed that is pausing looks at the board when its pause ends. So an editor who moves quickly wakes
// a watcher no more often than that.
//
// Errors   none
// Threads  the board is safe; a feed belongs to its stream, which locks it
#ifndef LATTICED_SERVER_ENGINE_SCENE_PRESENCE_H_
#define LATTICED_SERVER_ENGINE_SCENE_PRESENCE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/btree_set.h"
#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "core/base/vec.h"

namespace latticed {

class SceneListener;  // server/engine/scene/scene_listener.h

// How an editor looks at the scene: event.proto, Camera.
struct Camera {
  enum class Projection { kPerspective, kOrthographic };

  Vec3d position, target, up;
  Projection projection = Projection::kPerspective;
  double extent = 0;  // perspective: vertical angle in degrees; orthographic: height in world units
};

struct Presence {
  std::string editor_id;
  std::string name;
  uint32_t colour = 0;  // 0xRRGGBB
  std::vector<uint32_t> selected;
  uint32_t lattice = 0;  // of `selected`
  std::optional<Camera> camera;
  std::string following;  // the editor whose camera this one shows; empty: nobody
  bool left = false;      // the rest is empty then
};

class PresenceBoard {
 public:
  // A stream, which shows a presence and waits for others'.
  using Stream = const SceneListener*;
  // Editors' names, which feeds share with the board.
  using EditorName = std::shared_ptr<const std::string>;
  // Whom to wake, with no lock held.
  using Waiting = absl::flat_hash_map<Stream, std::weak_ptr<SceneListener>>;

  // Replaces what the editor showed before, through whichever stream.
  [[nodiscard]] Waiting Show(Stream stream, Presence presence) ABSL_LOCKS_EXCLUDED(mutex_);
  // The stream no longer waits. The editor has left unless another stream still shows the editor.
  [[nodiscard]] Waiting Leave(Stream stream, const std::string& editor_id)
      ABSL_LOCKS_EXCLUDED(mutex_);

  struct News {
    uint64_t version = 0;    // rises with every change
    uint64_t departure = 0;  // the version at which an editor left last
  };
  // nullopt when nothing has changed since `version`; `stream` is then woken by the next change.
  [[nodiscard]] std::optional<News> NewsSince(uint64_t version,
                                              const std::shared_ptr<SceneListener>& stream)
      ABSL_LOCKS_EXCLUDED(mutex_);
  struct Entry {
    uint64_t version = 0;  // at which it was shown
    EditorName editor;
    std::shared_ptr<const Presence> presence;
  };
  // The first that was shown after `version`.
  [[nodiscard]] std::optional<Entry> NextAfter(uint64_t version) const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] bool Shows(const std::string& editor_id) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Editor {
    uint64_t version = 0;
    absl::flat_hash_set<Stream> streams;  // that show this editor
  };
  mutable Mutex mutex_;
  News news_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, Entry> entries_ ABSL_GUARDED_BY(mutex_);  // by version
  absl::flat_hash_map<std::string, Editor> editors_ ABSL_GUARDED_BY(mutex_);
  Waiting waiting_ ABSL_GUARDED_BY(mutex_);
};

// Called with no lock of a stream held.
void Wake(const PresenceBoard::Waiting& waiting);

class PresenceFeed {
 public:
  // Tells nothing of `own_editor`. The board outlives the feed.
  PresenceFeed(PresenceBoard* board, std::string own_editor)
      : board_(board), own_editor_(std::move(own_editor)) {}

  // What to tell next; null when there is nothing, or nothing before wake_at(). Where time
  // changes nothing, `stream` is woken when there is something again.
  [[nodiscard]] std::shared_ptr<const Presence> Next(absl::Time now,
                                                     const std::shared_ptr<SceneListener>& stream);
  // InfiniteFuture where time changes nothing.
  absl::Time wake_at() const { return wake_at_; }

 private:
  struct ByName {
    bool operator()(const PresenceBoard::EditorName& a, const PresenceBoard::EditorName& b) const {
      return *a < *b;
    }
  };
  bool BeginTurn(const std::shared_ptr<SceneListener>& stream);
  std::shared_ptr<const Presence> NextOfTurn();

  PresenceBoard* const board_;
  const std::string own_editor_;
  uint64_t read_ = 0;                 // all that was shown up to this version
  std::optional<uint64_t> turn_end_;  // the version where the turn under way ends
  bool told_in_turn_ = false;         // what is its own is no reason to pause
  uint64_t departure_ = 0;
  absl::btree_set<PresenceBoard::EditorName, ByName> told_;
  std::vector<PresenceBoard::EditorName> left_;  // to be told
  absl::Time next_turn_ = absl::InfinitePast();
  absl::Time wake_at_ = absl::InfiniteFuture();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_PRESENCE_H_
