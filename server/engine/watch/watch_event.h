// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a watcher is sent, without a transport: the events of proto/latticed/v1/scene.proto's
// SceneEvent that follow from the scene.
//
//   lattice (whole, then deltas) | topology, quantisation when they change | begin, sum of lattices, patterns and batches, end
#ifndef LATTICED_SERVER_ENGINE_WATCH_WATCH_EVENT_H_
#define LATTICED_SERVER_ENGINE_WATCH_WATCH_EVENT_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/time/time.h"
#include "server/engine/render/snapshot.h"
#include "server/engine/scene/edit_log.h"
#include "server/engine/scene/scene_state.h"
#include "server/engine/watch/watch_view.h"

namespace latticed {

struct LatticeWhole {
  std::shared_ptr<const SceneState> state;
  size_t lattice = 0;
};
struct TopologyNews {
  std::string topology_id;
  std::shared_ptr<const Snapshot> snapshot;
};
struct QuantisationNews {
  std::shared_ptr<const Snapshot> snapshot;
};
// Patterns that the client does not have, PatternKey::Code of each, ascending.
struct PatternNews {
  static constexpr size_t kMost = 8;  // about 180 KB on the wire
  std::vector<uint16_t> codes;
};
struct UpdateBegins {
  uint64_t update_id = 0;
  uint64_t revision = 0;
  size_t chunk_count = 0;
  bool restart = false;
  WatchView view;  // the view in force
};
// The sum of several lattices, for a client that evaluates patches: what differs from the control points `before`, or all if
// that is null.
struct SumNews {
  std::shared_ptr<const Snapshot> snapshot;
  std::shared_ptr<const std::vector<Vec3d>> before;
};
struct ChunkBatch {
  uint64_t update_id = 0;
  std::string topology_id;
  std::shared_ptr<const Snapshot> snapshot;
  std::vector<uint32_t> chunks;
  size_t bytes = 0;
};
struct UpdateEnds {
  uint64_t update_id = 0;
  uint64_t revision = 0;
  uint64_t head_revision = 0;
  uint64_t applied_sequence = 0;
  bool full_detail = true;
  double certified_error = 0;
  std::string resume_token;
  absl::Duration queue_time, evaluate_time, encode_time, send_time;
};

using WatchEvent =
    std::variant<LatticeWhole, std::shared_ptr<const LatticeDelta>, TopologyNews, QuantisationNews,
                 PatternNews, UpdateBegins, SumNews, ChunkBatch, UpdateEnds>;

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_WATCH_EVENT_H_
