// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// When edits last moved each control point of a scene.
//
// Threads  plain data
#ifndef LATTICED_SERVER_ENGINE_SCENE_POINT_REVISIONS_H_
#define LATTICED_SERVER_ENGINE_SCENE_POINT_REVISIONS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ffd/outside/outside_map.h"

namespace latticed {

// By control point: the revision that moved it last. What is not known counts as moved at the revision `since`.
class PointRevisions {
 public:
  PointRevisions() = default;
  PointRevisions(size_t points, uint64_t since) : since_(since), revisions_(points, since) {}

  void Move(std::span<const uint32_t> points, uint64_t revision) {
    for (const uint32_t point : points) revisions_[point] = revision;
  }
  void MoveAll(uint64_t revision) { std::ranges::fill(revisions_, revision); }
  // By control point of the lattice that `outside` continues this one's to.
  [[nodiscard]] PointRevisions Continued(const OutsideMap& outside) const {
    if (outside.is_identity()) return *this;
    PointRevisions continued(outside.planned_count(), since_);
    for (size_t n = 0; n < continued.revisions_.size(); ++n) {
      outside.ForSources(n, [&](size_t source, double) {
        continued.revisions_[n] = std::max(continued.revisions_[n], revisions_[source]);
      });
    }
    return continued;
  }
  uint64_t since() const { return since_; }
  std::span<const uint64_t> revisions() const { return revisions_; }

 private:
  uint64_t since_ = 0;
  std::vector<uint64_t> revisions_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_POINT_REVISIONS_H_
