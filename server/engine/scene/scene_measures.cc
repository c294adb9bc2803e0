// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/scene_measures.h"

#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/measure/kept_volume.h"
#include "core/measure/surface_closure.h"

namespace latticed {

SceneMeasures::SceneMeasures(std::shared_ptr<const DeformPlan> plan, MemoryBudget* memory,
                             MemoryAccountPtr account, CpuArena* arena)
    : plan_(std::move(plan)), memory_(memory), account_(std::move(account)), arena_(arena) {}

absl::Status SceneMeasures::CheckClosed(std::span<const Vec3d> control_points) {
  uint64_t border_edges = 0;
  {
    const MutexLock lock(&mutex_);
    if (!border_edges_.has_value())
      border_edges_ = CountBorderEdges(*plan_->mesh, plan_->mesh_weights);
    border_edges = *border_edges_;
  }
  return latticed::CheckClosed(border_edges, CountTornEdges(*plan_, control_points));
}

absl::StatusOr<std::shared_ptr<const SurfaceMoments>> SceneMeasures::Moments(
    SurfaceMoments::Order order, StopCheck stop) {
  const MutexLock lock(&mutex_);
  if (moments_ != nullptr && moments_->order() >= order) return moments_;
  LATTICED_ASSIGN_OR_RETURN(
      auto reservation,
      memory_->Reserve("the surface's moments", SurfaceMoments::BytesFor(*plan_, order), account_));
  LATTICED_ASSIGN_OR_RETURN(auto moments, CatchBadAlloc("the surface's moments", [&] {
                              return SurfaceMoments::Make(plan_, order, stop);
                            }));
  bytes_ = reservation.bytes();
  reservation_ = std::move(reservation);
  moments_ = std::move(moments);
  return moments_;
}

absl::StatusOr<double> SceneMeasures::RestVolume() {
  LATTICED_ASSIGN_OR_RETURN(const auto moments, Moments(SurfaceMoments::Order::kVolume));
  const MutexLock lock(&mutex_);
  if (!rest_volume_.has_value()) rest_volume_ = latticed::RestVolume(*moments, arena_);
  return *rest_volume_;
}

SceneVolumeKeeper::SceneVolumeKeeper(std::shared_ptr<SceneMeasures> measures,
                                     std::shared_ptr<const OutsideMap> outside)
    : measures_(std::move(measures)), outside_(std::move(outside)) {}

absl::Status SceneVolumeKeeper::CheckEncloses(const std::vector<Vec3d>& control_points,
                                              double strength) const {
  return measures_->CheckClosed(At(strength)->Continue(control_points));
}

absl::Status SceneVolumeKeeper::Keep(const KeptVolume& kept, const PointFreedom* freedom,
                                     const std::vector<bool>& named, double strength,
                                     std::vector<Vec3d>& control_points) const {
  LATTICED_RETURN_IF_ERROR(CheckEncloses(control_points, strength));
  LATTICED_ASSIGN_OR_RETURN(const auto moments, measures_->Moments(SurfaceMoments::Order::kVolume));
  KeptVolume wanted = kept;
  if (!wanted.volume.has_value()) {
    LATTICED_ASSIGN_OR_RETURN(wanted.volume, measures_->RestVolume());
  }
  const auto outside = At(strength);
  return KeepVolume(*moments, wanted, freedom, named, control_points,
                    outside->is_identity() ? nullptr : outside.get(), measures_->arena())
      .status();
}

}  // namespace latticed
