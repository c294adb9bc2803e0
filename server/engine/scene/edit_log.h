// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the latest edits of a scene did, and who made them, for watchers whose lattice is a little behind.
//
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_SCENE_EDIT_LOG_H_
#define LATTICED_SERVER_ENGINE_SCENE_EDIT_LOG_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

// What one edit did to the control points. Watchers apply it to their lattice.
struct LatticeDelta {
  uint32_t lattice = 0;  // which of the scene's
  uint64_t revision = 0;
  uint64_t structure_id = 0;
  std::string editor_id;
  uint64_t sequence = 0;
  std::vector<uint32_t> indices;
  std::vector<Vec3d> positions;
  std::optional<double> strength;  // of the scene, if the edit changed it
  // Of a lattice with a higher number, which the same edit moved.
  std::shared_ptr<const LatticeDelta> also;
};

class EditLog {
 public:
  // Oldest first. `complete` is false when the log does not reach back far enough, no longer has the points,
  // or the structure has changed since: the watcher then needs the whole lattice.
  struct Deltas {
    bool complete = true;
    std::vector<std::shared_ptr<const LatticeDelta>> deltas;
  };

  // Adds the edit that made the newest revision. If it changed the structure or the constraints, a delta does not tell all:
  // the log forgets it and all earlier ones.
  void Add(const std::shared_ptr<const LatticeDelta>& delta, bool needs_whole);
  // An edit of an editor, from before the log began. Of several, the last one counts.
  void Remember(const std::string& editor_id, uint64_t sequence, uint64_t revision) {
    LastEdit& last = last_edits_[editor_id];
    if (sequence > last.sequence) last = {sequence, revision};
  }
  // Deltas after `revision` up to `newest`.
  [[nodiscard]] Deltas After(uint64_t revision, uint64_t newest) const;
  // The highest sequence number of an editor's edits that a state at `revision` holds. 0 for an unknown
  // editor; it may be too low for a revision that is older than the log.
  [[nodiscard]] uint64_t AppliedSequence(const std::string& editor_id, uint64_t revision) const;

  [[nodiscard]] uint64_t MemoryBytes() const;
  // Called when memory is short. Forgets the points of the oldest edit that still has them; else the oldest
  // edit; else the editor who has been silent longest. Returns false when only the newest is left.
  bool ForgetOldest();

 private:
  struct LastEdit {
    uint64_t sequence = 0;
    uint64_t revision = 0;
  };

  void ForgetPoints();
  void DropOldest();
  void ForgetEditor();

  std::deque<std::shared_ptr<const LatticeDelta>> deltas_;
  size_t emptied_ = 0;  // the oldest of them, whose points are forgotten
  size_t points_ = 0;   // of all deltas
  std::map<std::string, LastEdit> last_edits_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_EDIT_LOG_H_
