// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the latest edits of a scene did, for watchers whose cage is a little behind, and whose edits
// they were.
//
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_SCENE_EDIT_LOG_H_
#define LATTICED_SERVER_ENGINE_SCENE_EDIT_LOG_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

// What one edit did to the control points, so that every watcher's cage is true.
struct LatticeDelta {
  uint64_t revision = 0;
  uint64_t structure_id = 0;
  std::string editor_id;
  uint64_t sequence = 0;
  std::vector<uint32_t> indices;
  std::vector<Vec3d> positions;
};

class EditLog {
 public:
  // Oldest first; `complete` = false when the log does not reach back far enough, or no longer has
  // the points, or the structure has changed since: then the watcher wants the whole lattice.
  struct Deltas {
    bool complete = true;
    std::vector<std::shared_ptr<const LatticeDelta>> deltas;
  };

  // The edit that made the newest revision. Where it changed the structure, those before are
  // forgotten with it.
  void Add(const std::shared_ptr<const LatticeDelta>& delta, bool structure_changed);
  // Deltas after `revision` up to `newest`.
  [[nodiscard]] Deltas After(uint64_t revision, uint64_t newest) const;
  // The highest sequence of an editor that a state at `revision` holds, as far as is remembered: 0
  // for an unknown editor, and possibly too low for a revision that the log does not reach.
  [[nodiscard]] uint64_t AppliedSequence(const std::string& editor_id, uint64_t revision) const;

  [[nodiscard]] uint64_t MemoryBytes() const;
  // Where memory is short: forgets the points of the oldest edit that has them, else whose the oldest
  // was, else the editor silent longest; false where but the newest is left.
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
  size_t emptied_ = 0;  // of them the oldest, which say no more than whose they were
  size_t points_ = 0;   // of all deltas
  std::map<std::string, LastEdit> last_edits_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_EDIT_LOG_H_
