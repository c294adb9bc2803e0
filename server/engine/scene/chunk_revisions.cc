// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/chunk_revisions.h"

#include <map>

#include "core/ffd/dirty_set.h"
#include "core/ffd/lattice_edit.h"

namespace latticed {

MovedPoints::MovedPoints(const Lattice& lattice, uint64_t since)
    : since_(since),
      places_(lattice.control_points),
      revisions_(lattice.control_points.size(), since) {}

void MovedPoints::Note(const Lattice& lattice, uint64_t revision, bool all) {
  if (all || lattice.control_points.size() != places_.size()) {
    *this = MovedPoints(lattice, revision);
    return;
  }
  for (size_t i = 0; i < places_.size(); ++i) {
    if (SameBits(lattice.control_points[i], places_[i])) continue;
    places_[i] = lattice.control_points[i];
    revisions_[i] = revision;
  }
}

std::vector<uint64_t> MovedPoints::ChunkRevisions(
    const std::shared_ptr<const DeformPlan>& plan) const {
  std::map<uint64_t, std::vector<uint32_t>> moved;
  for (size_t i = 0; i < revisions_.size(); ++i) {
    if (revisions_[i] > since_) moved[revisions_[i]].push_back(static_cast<uint32_t>(i));
  }
  std::vector<uint64_t> chunks(plan->chunk_count(), since_);
  DirtySet dirty(plan);
  for (const auto& [revision, points] : moved) {
    dirty.MarkControlPoints(points);
    for (const uint32_t chunk : dirty.Chunks()) chunks[chunk] = revision;
    dirty.Clear();
  }
  return chunks;
}

}  // namespace latticed
