// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/edit_log.h"

#include <algorithm>
#include <iterator>

#include "core/base/limits.h"

namespace latticed {
namespace {

// A watcher that is more than kMaxDeltas edits behind is sent the whole lattice. When the edits of the log have
// more than kMaxPoints points together, the oldest lose their points and keep only who made them.
constexpr size_t kMaxDeltas = 256;
constexpr size_t kMaxPoints = 262'144;

size_t PointsOf(const LatticeDelta& delta) {
  return delta.indices.size() + (delta.also == nullptr ? 0 : PointsOf(*delta.also));
}

}  // namespace

void EditLog::Add(const std::shared_ptr<const LatticeDelta>& delta, bool needs_whole) {
  if (needs_whole) {
    deltas_.clear();
    emptied_ = points_ = 0;
  } else {
    points_ += PointsOf(*delta);
    deltas_.push_back(delta);
  }
  while (deltas_.size() > kMaxDeltas) DropOldest();
  while (points_ > kMaxPoints) ForgetPoints();
  last_edits_[delta->editor_id] = {delta->sequence, delta->revision};
  if (last_edits_.size() > static_cast<size_t>(limits::kMaxEditorsRemembered)) ForgetEditor();
}

void EditLog::ForgetPoints() {
  auto& delta = deltas_[emptied_++];
  points_ -= PointsOf(*delta);
  delta = std::make_shared<const LatticeDelta>(LatticeDelta{.revision = delta->revision,
                                                            .structure_id = delta->structure_id,
                                                            .editor_id = delta->editor_id,
                                                            .sequence = delta->sequence});
}

void EditLog::DropOldest() {
  points_ -= PointsOf(*deltas_.front());
  deltas_.pop_front();
  if (emptied_ > 0) --emptied_;
}

void EditLog::ForgetEditor() {
  last_edits_.erase(std::ranges::min_element(
      last_edits_, {}, [](const auto& entry) { return entry.second.revision; }));
}

uint64_t EditLog::MemoryBytes() const {
  // Bytes: the longest editor id, and what the nodes and blocks of the containers add to an entry.
  constexpr uint64_t kEditor = 80, kNodes = 64;
  return points_ * (sizeof(uint32_t) + sizeof(Vec3d)) +
         deltas_.size() * (sizeof(LatticeDelta) + kEditor + kNodes) +
         last_edits_.size() * (sizeof(std::string) + sizeof(LastEdit) + kEditor + kNodes);
}

bool EditLog::ForgetOldest() {
  if (emptied_ + 1 < deltas_.size()) {
    ForgetPoints();
  } else if (deltas_.size() > 1) {
    DropOldest();
  } else if (last_edits_.size() > 1) {
    ForgetEditor();
  } else {
    return false;
  }
  return true;
}

EditLog::Deltas EditLog::After(uint64_t revision, uint64_t newest) const {
  if (revision >= newest) return {};
  if (emptied_ == deltas_.size() || deltas_[emptied_]->revision > revision + 1) {
    return {.complete = false};
  }
  Deltas result;
  const auto first = static_cast<std::ptrdiff_t>(revision + 1 - deltas_.front()->revision);
  result.deltas.assign(std::next(deltas_.begin(), first), deltas_.end());
  return result;
}

uint64_t EditLog::AppliedSequence(const std::string& editor_id, uint64_t revision) const {
  const auto last = last_edits_.find(editor_id);
  if (last == last_edits_.end()) return 0;
  if (last->second.revision <= revision) return last->second.sequence;
  for (auto delta = deltas_.rbegin(); delta != deltas_.rend(); ++delta) {
    if ((*delta)->revision <= revision && (*delta)->editor_id == editor_id) {
      return (*delta)->sequence;
    }
  }
  return 0;
}

}  // namespace latticed
