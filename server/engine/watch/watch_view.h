// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_SERVER_ENGINE_WATCH_WATCH_VIEW_H_
#define LATTICED_SERVER_ENGINE_WATCH_WATCH_VIEW_H_

#include <cstdint>
#include <optional>

#include "server/engine/render/snapshot.h"

namespace latticed {

// A view as one watcher asks for it.
struct WatchView {
  ViewKey key;
  // Of a view without positions: the normals that the client's own points have. The key has none then, because edge
  // bounds do not depend on them: watchers with any normals share one evaluation.
  std::optional<NormalMode> client_normals;
  // While edits come, segments are lowered to keep to these (level_of_detail.h). 0: no limit.
  uint64_t max_points = 0;
  uint64_t max_bytes_per_second = 0;
  // Used while a gesture is open. 0: those of the key.
  int drag_position_bits = 0;
  int drag_normal_bits = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_WATCH_VIEW_H_
