// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points that clients keep beside a scene, and all such sets of one scene. They are in memory only.
//
//   Add -> Find -> At(state) -> PointEvaluator, sorted again if the state has another structure
//   Remove, or the end of the scene: the memory is free when the last call that uses the points has ended
//
// Errors   kNotFound; kResourceExhausted, reasons OUT_OF_MEMORY and LIMIT_EXCEEDED, of the device too; those of RenderBackend
// Threads  safe. Sorting again takes 0.1 s per million points and thread; other callers of the set wait.
#ifndef LATTICED_SERVER_ENGINE_POINTS_POINT_SET_H_
#define LATTICED_SERVER_ENGINE_POINTS_POINT_SET_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/points/point_evaluator.h"
#include "core/points/sorted_points.h"
#include "server/engine/memory/memory_budget.h"
#include "server/engine/render/render_backend.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

class PointSet {
 public:
  // Sets of so many points are evaluated by the backend's device, if it has one and they have no weights. The host has the
  // vectors of smaller sets sooner than a device.
  static constexpr size_t kLeastDevicePoints = 16'384;

  // Points at rest, as SortedPoints takes them.
  struct Source {
    std::span<const Vec3d> points, normals;
    std::span<const PointWeight> weights;
  };
  // Sorted points where they are evaluated, with the host memory that they take. They are sorted once per lattice, if lattices
  // are turned against each other.
  struct Resident {
    std::shared_ptr<PointEvaluator> evaluator;
    uint64_t structure_id = 0;
    MemoryReservation memory;

    const SortedPoints& points() const { return evaluator->points(); }
  };

  // What a set takes, but for its runs, which are few.
  [[nodiscard]] static uint64_t BytesFor(const DeformPlan& plan, uint64_t points, bool with_normals,
                                         bool with_weights);

  // Sorts the points for the state's structure. The set is charged to `account`.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<PointSet>> Make(
      std::string id, const SceneState& state, const Source& source, RenderBackend& backend,
      const MemoryAccountPtr& account, CpuArena& arena);

  const std::string& id() const { return id_; }
  absl::Time create_time() const { return create_time_; }
  // As they were last sorted.
  [[nodiscard]] std::shared_ptr<const Resident> Newest() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Sorted for the state's structure. The result keeps the points alive.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const Resident>> At(const SceneState& state,
                                                                   RenderBackend& backend,
                                                                   CpuArena& arena)
      ABSL_LOCKS_EXCLUDED(sort_mutex_, mutex_);

 private:
  PointSet(std::string id, std::shared_ptr<const Resident> resident)
      : id_(std::move(id)), create_time_(absl::Now()), newest_(std::move(resident)) {}

  const std::string id_;
  const absl::Time create_time_;
  Mutex sort_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);  // held while points are sorted again
  mutable Mutex mutex_;
  std::shared_ptr<const Resident> newest_ ABSL_GUARDED_BY(mutex_);
};

class PointSets {
 public:
  [[nodiscard]] absl::Status Add(std::shared_ptr<PointSet> set) ABSL_LOCKS_EXCLUDED(mutex_);
  // LIMIT_EXCEEDED where Add would refuse one more.
  [[nodiscard]] absl::Status CheckRoom() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::StatusOr<std::shared_ptr<PointSet>> Find(std::string_view id) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::Status Remove(std::string_view id) ABSL_LOCKS_EXCLUDED(mutex_);
  // Oldest first.
  [[nodiscard]] std::vector<std::shared_ptr<PointSet>> All() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] uint64_t MemoryBytes() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  [[nodiscard]] absl::Status CheckRoomLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable Mutex mutex_;
  std::vector<std::shared_ptr<PointSet>> sets_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_POINTS_POINT_SET_H_
