// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/points/point_set.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/points/host_points.h"
#include "core/points/summed_points.h"

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

// Of several lattices: their sum.
absl::StatusOr<std::shared_ptr<PointEvaluator>> EvaluatorOf(
    const std::vector<std::shared_ptr<const SortedPoints>>& points, RenderBackend& backend,
    CpuArena& arena) {
  if (points.size() == 1) return EvaluatorOf(points.front(), backend, arena);
  std::vector<std::shared_ptr<PointEvaluator>> evaluators;
  for (const auto& of_lattice : points) {
    LATTICED_ASSIGN_OR_RETURN(auto evaluator, EvaluatorOf(of_lattice, backend, arena));
    evaluators.push_back(std::move(evaluator));
  }
  return std::make_shared<SummedPoints>(std::move(evaluators), &arena);
}

// make(structure, with_normals) returns the points sorted for a structure. `bytes`: of the points; `more`: those that only
// making them takes.
template <class Make>
absl::StatusOr<std::shared_ptr<const PointSet::Resident>> MakeResident(
    uint64_t bytes, uint64_t more, const SceneState& state, RenderBackend& backend,
    const MemoryAccountPtr& account, CpuArena& arena, const Make& make) {
  LATTICED_ASSIGN_OR_RETURN(auto room, backend.memory().Reserve(kWhat, bytes + more, account));
  std::vector<std::shared_ptr<const SortedPoints>> points;
  points.push_back(std::make_shared<const SortedPoints>(make(state.plan->structure, true)));
  for (const TurnedLattice& turned : state.plan->turned) {
    points.push_back(std::make_shared<const SortedPoints>(make(turned.structure, false)));
  }
  uint64_t taken = 0;
  for (const auto& of_lattice : points) taken += of_lattice->MemoryBytes();
  LATTICED_RETURN_IF_ERROR(room.Resize(kWhat, taken));
  LATTICED_ASSIGN_OR_RETURN(auto evaluator, EvaluatorOf(points, backend, arena));
  return std::make_shared<const PointSet::Resident>(
      PointSet::Resident{std::move(evaluator), state.structure_id, std::move(room)});
}

}  // namespace

// Those of turned lattices are sorted without normals, which follow from the sum.
uint64_t PointSet::BytesFor(const DeformPlan& plan, uint64_t points, bool with_normals,
                            bool with_weights) {
  return SortedPoints::BytesFor(points, with_normals, with_weights) +
         plan.turned.size() * SortedPoints::BytesFor(points, false, with_weights);
}

absl::StatusOr<std::shared_ptr<PointSet>> PointSet::Make(std::string id, const SceneState& state,
                                                         const Source& source,
                                                         RenderBackend& backend,
                                                         const MemoryAccountPtr& account,
                                                         CpuArena& arena) {
  const size_t count = source.points.size();
  LATTICED_ASSIGN_OR_RETURN(
      auto resident,
      MakeResident(BytesFor(*state.plan, count, !source.normals.empty(), !source.weights.empty()),
                   SortingBytes(count), state, backend, account, arena,
                   [&](const LatticeStructure& structure, bool with_normals) {
                     return SortedPoints(structure, source.points,
                                         with_normals ? source.normals : std::span<const Vec3d>(),
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
  auto old = Newest();
  if (old->structure_id == state.structure_id) return old;
  const MutexLock sort_lock(&sort_mutex_);
  old = Newest();
  if (old->structure_id == state.structure_id) return old;
  const SortedPoints& points = old->points();
  const uint64_t bytes =
      BytesFor(*state.plan, points.size(), points.has_normals(), points.has_weights());
  LATTICED_ASSIGN_OR_RETURN(
      auto sorted, MakeResident(bytes, SortingBytes(points.size()) + CopyBytes(points), state,
                                backend, old->memory.account(), arena,
                                [&](const LatticeStructure& structure, bool with_normals) {
                                  return points.Resorted(structure, arena, with_normals);
                                }));
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
