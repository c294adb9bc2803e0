// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/volume_restorer.h"

#include "core/base/status_macros.h"
#include "core/ffd/control_point_range.h"

namespace latticed {

std::optional<uint32_t> RestorerOf(const EditBatch& batch, const SceneState& state) {
  const bool removes = LoneEdit<RemoveLattice>(batch) != nullptr;
  if (batch.keep_volume.has_value() && !removes) return std::nullopt;
  const size_t own = PlaceOf(state.lattices, batch.lattice);
  const bool keeps = own < state.lattices.size() && !removes &&
                     state.lattices[own].constraints->volume.has_value();
  if (keeps) return std::nullopt;
  for (size_t k = 0; k < state.lattices.size(); ++k) {
    const SceneLattice& lattice = state.lattices[k];
    if (k != own && lattice.constraints->volume.has_value()) return lattice.number;
  }
  return std::nullopt;
}

std::optional<SceneState> WithoutRestored(const EditBatch& batch, const SceneState& state,
                                          const SceneHistory& history) {
  std::optional<SceneState> result;
  if (batch.gesture_id.empty() || state.lattices.size() == 1) return result;
  for (size_t k = 0; k < state.lattices.size(); ++k) {
    const auto points = history.PointsBefore(batch, state.lattices[k].number);
    if (!points.has_value()) continue;
    if (!result.has_value()) result = state;
    TakePoints(result->lattices, k, state.lattices[k].map->strength(), *points);
  }
  return result;
}

absl::StatusOr<RestoredPoints> RestoreVolume(uint32_t number, const SceneHistory& history,
                                             SceneState& planned) {
  const size_t place = PlaceOf(planned.lattices, number);
  const SceneLattice& lattice = planned.lattices[place];
  const Constraints& constraints = history.of(number).constraints();
  const double strength = lattice.map->strength();
  std::optional<PointFreedom> freedom;
  if (!constraints.points_are_free()) freedom.emplace(constraints, lattice.structure());
  const std::vector<Vec3d> before = *lattice.points;
  std::vector<Vec3d> points = before;
  const SceneVolumeKeeper keeper(planned.measures, MapAmongOthers(planned.lattices, place));
  LATTICED_RETURN_IF_ERROR(keeper.Keep(*constraints.volume,
                                       freedom.has_value() ? &*freedom : nullptr,
                                       std::vector<bool>(points.size()), strength, points));
  RestoredPoints restored{.lattice = number, .moved = {}};
  for (uint32_t i = 0; i < points.size(); ++i) {
    if (SameBits(before[i], points[i])) continue;
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(points[i], "keep_volume"));
    restored.moved.indices.push_back(i);
    restored.moved.positions.push_back(points[i]);
  }
  TakePoints(planned.lattices, place, strength, points);
  return restored;
}

}  // namespace latticed
