// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The steps of an EditHistory that follow steps of another lattice.
#include <algorithm>
#include <string>
#include <utility>

#include "core/ffd/history/edit_history.h"

namespace latticed {

std::optional<size_t> EditHistory::FindFollower(const FollowedStep& of) const {
  const auto& steps = layers_.steps();
  for (size_t n = steps.size(); n-- > 0;) {
    if (steps[n].follows != of) continue;
    if (IsOfPresentStructure(steps[n])) return n;
  }
  return std::nullopt;
}

void EditHistory::AddFollower(std::string_view editor_id, const FollowedStep& of,
                              SetControlPoints moved) {
  EditStep step = NewStep(std::string(editor_id));
  step.indices = std::move(moved.indices);
  step.positions = std::move(moved.positions);
  step.follows = of;
  layers_.Push(std::move(step));
  TrimHistory();
}

bool EditHistory::TakeFollower(const FollowedStep& of, std::string_view undone_by) {
  const auto found = FindFollower(of);
  if (!found.has_value()) return false;
  EditStep step = layers_.Remove(*found);
  if (undone_by.empty()) return true;
  undone_bytes_ += step.MemoryBytes();
  undone_.push_back({std::move(step), std::string(undone_by), ++clock_});
  TrimHistory();
  return true;
}

bool EditHistory::RedoFollower(const FollowedStep& of, uint64_t step) {
  const auto found =
      std::ranges::find_if(undone_, [&](const UndoneStep& u) { return u.step.follows == of; });
  if (found == undone_.end()) return false;
  const uint64_t undone_at = found->undone_at;
  EditStep follower = TakeUndone(found);
  if (!IsOfPresentStructure(follower)) return false;
  // What others have written since stays. The next edit restores the volume.
  for (const EditStep& later : layers_.steps()) {
    const bool others = later.editor_id != follower.editor_id;
    if (others && later.written_at > undone_at && later.Overlaps(follower)) return false;
  }
  follower.follows = FollowedStep{of.lattice, step};
  follower.written_at = ++clock_;
  layers_.Push(std::move(follower));
  TrimHistory();
  return true;
}

void EditHistory::ForgetFollowers(uint32_t lattice, std::string_view undone_by) {
  std::erase_if(undone_, [&](const UndoneStep& undone) {
    if (undone.undone_by != undone_by || !undone.step.follows.has_value() ||
        undone.step.follows->lattice != lattice) {
      return false;
    }
    undone_bytes_ -= undone.step.MemoryBytes();
    return true;
  });
}

std::optional<std::vector<Vec3d>> EditHistory::PointsWithoutFollower(const FollowedStep& of) const {
  const auto found = FindFollower(of);
  if (!found.has_value()) return std::nullopt;
  return layers_.PointsWithout(*found);
}

}  // namespace latticed
