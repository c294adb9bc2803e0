// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A snapshot: the complete set of chunks of a view at one revision.
//
// Chunks whose bytes did not change are shared with the snapshot before, revision and all.
//
// Threads  immutable once it is published
#ifndef LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_H_
#define LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/time/time.h"
#include "core/backend.h"
#include "core/base/vec.h"
#include "server/engine/render/chunk_table.h"

namespace latticed {

// What distinguishes views: watchers with the same key share one evaluation and one encoding.
struct ViewKey {
  ViewSpec spec;
  Encoding encoding = Encoding::kDracoPoints;
  friend auto operator<=>(const ViewKey&, const ViewKey&) = default;
};

[[nodiscard]] inline uint64_t QuantisationId(const ViewKey& view, const QuantisationBox& box) {
  return HasPositions(view.spec) ? box.id : 0;
}

// The first snapshot of a view and a structure. Its chunks have the revisions of the edits that reached them. These hold
// for clients whose patterns were chosen with the same tolerance: another one changes patterns far from any edit.
struct FirstSnapshot {
  uint64_t revision = 0;
  double curvature_tolerance = 0;
};

struct Snapshot {
  uint64_t number = 0;  // rises within a view, from 1
  ViewKey view;
  uint64_t revision = 0;
  uint64_t structure_id = 0;
  QuantisationBox box;
  // The grid of its chunks: 0 for a view without positions.
  uint64_t quantisation_id() const { return QuantisationId(view, box); }
  std::shared_ptr<const DeformPlan> plan;
  ChunkTable chunks;
  PatternCodes patterns;  // of a view with a tolerance
  // Of a chunk on the wire: its data and its patterns.
  size_t BytesOf(uint32_t chunk) const {
    return chunks[chunk].data.size() + patterns.OfChunk(chunk).size_bytes();
  }
  // Of bounds: FirstEdges of the plan. Else null.
  std::shared_ptr<const std::vector<uint32_t>> first_edges;
  // Of bounds, in a scene of several lattices: the control points of their sum, which is the plan's lattice. Else null.
  std::shared_ptr<const std::vector<Vec3d>> summed_points;
  uint64_t held_bytes = 0;         // what the chunks keep in memory; chunk_blocks.h
  double certified_error = 0;      // DeformView::certified_error
  double curvature_tolerance = 0;  // DeformView::curvature_tolerance
  FirstSnapshot first;
  absl::Time edit_time;  // when the edit that made the revision was committed
  absl::Duration evaluate_time;
  absl::Duration encode_time;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_H_
