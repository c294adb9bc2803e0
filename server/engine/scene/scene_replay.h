// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene's history, made again from its log.
//
// Errors   kDataLoss naming the record
// Threads  pure functions
#ifndef LATTICED_SERVER_ENGINE_SCENE_SCENE_REPLAY_H_
#define LATTICED_SERVER_ENGINE_SCENE_SCENE_REPLAY_H_

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/ffd/plan/quantisation_box.h"
#include "server/engine/lattices/scene_history.h"
#include "server/engine/scene/point_revisions.h"
#include "server/store/store.h"

namespace latticed {

// When revisions were committed, ascending.
using CommitTimes = std::vector<std::pair<uint64_t, absl::Time>>;
// The most that are kept: those of 40 s with 200 edits a second. A client tries for 30 s to come back.
inline constexpr size_t kMostCommitTimes = 8'192;

// What a scene was when it made its last record.
struct SceneLife {
  SceneHistory history;
  std::optional<QuantisationBox> box;         // none: no edit has come yet
  std::chrono::steady_clock::time_point now;  // on the scene's clock
  absl::Time commit_time;
  uint64_t replayed = 0;  // records since the last snapshot
  PointRevisions
      moved;  // by those records: points of the first lattice; of several, all points by each
  CommitTimes commits;  // of those records and the one before, the last kMostCommitTimes
};

// What the log does not hold of the scene's mesh. Without it, weights are not compared with the mesh.
struct ReplayedMesh {
  VertexWeights weights;  // with which the scene was made
  size_t vertices = 0;
};

[[nodiscard]] absl::StatusOr<SceneLife> Replay(const SceneLog& log, const ReplayedMesh& mesh = {});

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_SCENE_REPLAY_H_
