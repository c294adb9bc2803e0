// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluated vertices -> the snapshot of their revision.
//
// Errors   the backend's; what `between` says
// Threads  holds no lock; uses `vertices` until it returns
#ifndef LATTICED_SERVER_ENGINE_RENDER_ENCODE_SNAPSHOT_H_
#define LATTICED_SERVER_ENGINE_RENDER_ENCODE_SNAPSHOT_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "server/engine/render/snapshot.h"

namespace latticed {

struct SceneState;  // server/engine/scene.h

// How far an encoding has come, in chunks.
struct EncodeProgress {
  size_t done = 0;
  size_t left = 0;
  size_t batch = 0;  // DeformView::encode_batch
  absl::Duration spent;
  // Whether what is left takes no longer than `time`, or a batch, below which nobody can tell.
  bool EndsWithin(absl::Duration time) const;
};

// Encodes `chunks` and takes the others from `before`, which may be null if `chunks` are all. A
// chunk whose vertices are those of its old bytes is not encoded and keeps its revision, as does one
// whose new bytes equal the old ones. `between` is asked before every batch and ends the work with
// its status.
[[nodiscard]] absl::StatusOr<std::shared_ptr<Snapshot>> EncodeSnapshot(
    const ViewKey& key, const SceneState& state, std::span<const uint32_t> chunks,
    DeformView& vertices, const Snapshot* before,
    const std::function<absl::Status(const EncodeProgress&)>& between);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_ENCODE_SNAPSHOT_H_
