// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// When edits last reached each chunk of a scene. A view that is made anew, also by another server, knows by them which
// chunks a client has already.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_ENGINE_SCENE_CHUNK_REVISIONS_H_
#define LATTICED_SERVER_ENGINE_SCENE_CHUNK_REVISIONS_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "core/ffd/deform_plan.h"
#include "core/ffd/lattice.h"

namespace latticed {

// By control point: the revision that moved it last. What is not known counts as moved at the revision `since`.
class MovedPoints {
 public:
  MovedPoints() = default;
  MovedPoints(const Lattice& lattice, uint64_t since);

  // The lattice is at `revision` now. Another number of control points, or `all`: all have moved.
  void Note(const Lattice& lattice, uint64_t revision, bool all);

  // By chunk of the lattice's plan: the revision of the last edit that may have changed it.
  [[nodiscard]] std::vector<uint64_t> ChunkRevisions(
      const std::shared_ptr<const DeformPlan>& plan) const;

 private:
  uint64_t since_ = 0;
  std::vector<Vec3d> places_;
  std::vector<uint64_t> revisions_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_CHUNK_REVISIONS_H_
