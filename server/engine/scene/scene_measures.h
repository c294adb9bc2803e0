// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What measures of a scene's surface need besides the control points. It follows from the plan, and is made when it is
// first asked for: the moments of volume or centroid (core/measure/surface_moments.h), the number of border edges, the
// rest volume. Their bytes are reserved in the budget.
//
// Errors   kResourceExhausted; what `stop` returns; kFailedPrecondition OPEN_SURFACE
// Threads  safe. Who asks for what another thread is making waits for it
#ifndef LATTICED_SERVER_ENGINE_SCENE_SCENE_MEASURES_H_
#define LATTICED_SERVER_ENGINE_SCENE_SCENE_MEASURES_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "core/base/stop_check.h"
#include "core/ffd/constraints/volume_keeper.h"
#include "core/ffd/outside/outside_map.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/measure/surface_moments.h"
#include "server/engine/memory/memory_budget.h"

namespace latticed {

class CpuArena;  // core/view/cpu_arena.h

class SceneMeasures {
 public:
  // `memory` and `arena` outlive this. The account and the arena may be null.
  SceneMeasures(std::shared_ptr<const DeformPlan> plan, MemoryBudget* memory,
                MemoryAccountPtr account, CpuArena* arena);
  SceneMeasures(const SceneMeasures&) = delete;  // states share it
  SceneMeasures& operator=(const SceneMeasures&) = delete;

  [[nodiscard]] absl::Status CheckClosed(std::span<const Vec3d> control_points)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Moments of this order or a higher one. Those of a plan with weights are for the volume alone.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const SurfaceMoments>> Moments(
      SurfaceMoments::Order order, StopCheck stop = NeverStop) ABSL_LOCKS_EXCLUDED(mutex_);
  // The volume at rest of a closed surface.
  [[nodiscard]] absl::StatusOr<double> RestVolume() ABSL_LOCKS_EXCLUDED(mutex_);
  uint64_t MemoryBytes() const { return bytes_; }
  // The threads that measure; null: the caller's alone.
  CpuArena* arena() const { return arena_; }

 private:
  const std::shared_ptr<const DeformPlan> plan_;
  MemoryBudget* const memory_;
  const MemoryAccountPtr account_;
  CpuArena* const arena_;
  std::atomic<uint64_t> bytes_ = 0;
  Mutex mutex_;
  MemoryReservation reservation_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const SurfaceMoments> moments_ ABSL_GUARDED_BY(mutex_);
  std::optional<uint64_t> border_edges_ ABSL_GUARDED_BY(mutex_);
  std::optional<double> rest_volume_ ABSL_GUARDED_BY(mutex_);
};

// Keeps volumes for the edits of a scene.
class SceneVolumeKeeper final : public VolumeKeeper {
 public:
  SceneVolumeKeeper(std::shared_ptr<SceneMeasures> measures,
                    std::shared_ptr<const OutsideMap> outside);

  [[nodiscard]] absl::Status CheckEncloses(const std::vector<Vec3d>& control_points,
                                           double strength) const override;
  [[nodiscard]] absl::Status Keep(const KeptVolume& kept, const PointFreedom* freedom,
                                  const std::vector<bool>& named, double strength,
                                  std::vector<Vec3d>& control_points) const override;

 private:
  // The map at this strength.
  [[nodiscard]] std::shared_ptr<const OutsideMap> At(double strength) const {
    return WithStrength(outside_, strength);
  }

  const std::shared_ptr<SceneMeasures> measures_;
  const std::shared_ptr<const OutsideMap> outside_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_SCENE_MEASURES_H_
