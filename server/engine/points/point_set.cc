// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/points/point_set.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/points/host_points.h"

namespace latticed {
namespace {

constexpr char kWhat[] = "the point set";

// While points are sorted, each has the number of its box as well; to sort them again, they are copied first.
uint64_t SortingBytes(uint64_t points) { return points * sizeof(uint32_t); }
uint64_t CopyBytes(const SortedPoints& points) {
  return points.size() * (sizeof(Vec3d) * (points.has_normals() ? 2 : 1) +
                          (points.has_weights() ? sizeof(PointWeight) : 0));
}

absl::StatusOr<std::shared_ptr<PointEvaluator>> EvaluatorOf(
    std::shared_ptr<const SortedPoints> points, RenderBackend& backend, CpuArena& arena) {
  // Devices do not weigh points.
  if (points->size() >= PointSet::kLeastDevicePoints && !points->has_weights()) {
    LATTICED_ASSIGN_OR_RETURN(auto on_device, backend.PreparePoints(points));
    if (on_device != nullptr) return on_device;
  }
  return std::make_shared<HostPoints>(std::move(points), &arena);
}

// `make` returns the sorted points. `bytes`: of the points; `more`: those that only making them takes.
template <class Make>
absl::StatusOr<std::shared_ptr<const PointSet::Resident>> MakeResident(
    uint64_t bytes, uint64_t more, uint64_t structure_id, RenderBackend& backend,
    const MemoryAccountPtr& account, CpuArena& arena, const Make& make) {
  LATTICED_ASSIGN_OR_RETURN(auto room, backend.memory().Reserve(kWhat, bytes + more, account));
  const auto points = std::make_shared<const SortedPoints>(make());
  LATTICED_RETURN_IF_ERROR(room.Resize(kWhat, points->MemoryBytes()));
  LATTICED_ASSIGN_OR_RETURN(auto evaluator, EvaluatorOf(points, backend, arena));
  return std::make_shared<const PointSet::Resident>(
      PointSet::Resident{std::move(evaluator), structure_id, std::move(room)});
}

}  // namespace

absl::StatusOr<std::shared_ptr<PointSet>> PointSet::Make(std::string id, const SceneState& state,
                                                         const Source& source,
                                                         RenderBackend& backend,
                                                         const MemoryAccountPtr& account,
                                                         CpuArena& arena) {
  if (!state.plan->turned.empty()) return error::NotWithTurned("a point set");
  const size_t count = source.points.size();
  LATTICED_ASSIGN_OR_RETURN(
      auto resident,
      MakeResident(SortedPoints::BytesFor(count, !source.normals.empty(), !source.weights.empty()),
                   SortingBytes(count), state.structure_id, backend, account, arena, [&] {
                     return SortedPoints(state.plan->structure, source.points, source.normals,
                                         arena, source.weights);
                   }));
  return std::shared_ptr<PointSet>(new PointSet(std::move(id), std::move(resident)));
}

std::shared_ptr<const PointSet::Resident> PointSet::Newest() const {
  const MutexLock lock(&mutex_);
  return newest_;
}

absl::StatusOr<std::shared_ptr<const PointSet::Resident>> PointSet::At(const SceneState& state,
                                                                       RenderBackend& backend,
                                                                       CpuArena& arena) {
  if (!state.plan->turned.empty()) return error::NotWithTurned("a point set");
  auto old = Newest();
  if (old->structure_id == state.structure_id) return old;
  const MutexLock sort_lock(&sort_mutex_);
  old = Newest();
  if (old->structure_id == state.structure_id) return old;
  const SortedPoints& points = old->points();
  const uint64_t bytes =
      SortedPoints::BytesFor(points.size(), points.has_normals(), points.has_weights());
  LATTICED_ASSIGN_OR_RETURN(
      auto sorted, MakeResident(bytes, SortingBytes(points.size()) + CopyBytes(points),
                                state.structure_id, backend, old->memory.account(), arena,
                                [&] { return points.Resorted(state.plan->structure, arena); }));
  const MutexLock lock(&mutex_);
  // A call at an older state must not undo what a newer one has sorted.
  if (newest_->structure_id < sorted->structure_id) newest_ = sorted;
  return sorted;
}

absl::Status PointSets::CheckRoom() const {
  const MutexLock lock(&mutex_);
  return CheckRoomLocked();
}

absl::Status PointSets::CheckRoomLocked() const {
  if (sets_.size() < static_cast<size_t>(limits::kMaxPointSetsPerScene)) return absl::OkStatus();
  return error::LimitExceeded("point sets of a scene", limits::kMaxPointSetsPerScene);
}

absl::Status PointSets::Add(std::shared_ptr<PointSet> set) {
  const MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(CheckRoomLocked());
  sets_.push_back(std::move(set));
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<PointSet>> PointSets::Find(std::string_view id) const {
  const MutexLock lock(&mutex_);
  const auto found = std::ranges::find(sets_, id, [](const auto& set) { return set->id(); });
  if (found == sets_.end()) return error::NotFound("point_set", id);
  return *found;
}

absl::Status PointSets::Remove(std::string_view id) {
  std::shared_ptr<PointSet> removed;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  const auto found = std::ranges::find(sets_, id, [](const auto& set) { return set->id(); });
  if (found == sets_.end()) return error::NotFound("point_set", id);
  removed = std::move(*found);
  sets_.erase(found);
  return absl::OkStatus();
}

std::vector<std::shared_ptr<PointSet>> PointSets::All() const {
  const MutexLock lock(&mutex_);
  return sets_;
}

uint64_t PointSets::MemoryBytes() const {
  uint64_t bytes = 0;
  for (const auto& set : All()) bytes += set->Newest()->memory.bytes();
  return bytes;
}

}  // namespace latticed
