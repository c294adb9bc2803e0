// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The volume that a lattice of a scene keeps, after an edit of another one: the lattice that keeps it moves.
//
// Errors   those of VolumeKeeper
// Threads  pure functions; one at a time for the history
#ifndef LATTICED_SERVER_ENGINE_SCENE_VOLUME_RESTORER_H_
#define LATTICED_SERVER_ENGINE_SCENE_VOLUME_RESTORER_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/ffd/constraints/volume_keeper.h"
#include "core/ffd/history/edit_record.h"
#include "server/engine/lattices/scene_history.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

// The number of the lattice that restores the volume after the batch: none if the batch's own lattice does, or the batch says
// what is kept; else the first one that keeps it.
[[nodiscard]] std::optional<uint32_t> RestorerOf(const EditBatch& batch, const SceneState& state);
// The state without what an earlier update of the batch's gesture moved in other lattices; nullopt if there is nothing.
[[nodiscard]] std::optional<SceneState> WithoutRestored(const EditBatch& batch,
                                                        const SceneState& state,
                                                        const SceneHistory& history);
// Moves points of the lattice `number` so that the volume of `planned`, all of whose lattices have their points, is what this
// lattice keeps. Those that moved are returned.
[[nodiscard]] absl::StatusOr<RestoredPoints> RestoreVolume(uint32_t number,
                                                           const SceneHistory& history,
                                                           SceneState& planned);

// A keeper that is made when it is asked: the plan of a batch is not there before.
class LazyVolumeKeeper final : public VolumeKeeper {
 public:
  explicit LazyVolumeKeeper(std::function<SceneVolumeKeeper()> make) : make_(std::move(make)) {}

  [[nodiscard]] absl::Status CheckEncloses(const std::vector<Vec3d>& control_points,
                                           double strength) const override {
    return make_().CheckEncloses(control_points, strength);
  }
  [[nodiscard]] absl::Status Keep(const KeptVolume& kept, const PointFreedom* freedom,
                                  const std::vector<bool>& named, double strength,
                                  std::vector<Vec3d>& control_points) const override {
    return make_().Keep(kept, freedom, named, strength, control_points);
  }

 private:
  std::function<SceneVolumeKeeper()> make_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_VOLUME_RESTORER_H_
