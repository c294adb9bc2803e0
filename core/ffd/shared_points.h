// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The owners of points that patches share, for pipelines that evaluate every patch by itself.
//
// Each plan vertex, and each plan edge without its ends, has one owner: the lowest patch of its
// owner box that uses it (the lowest of all where that box has none). All others copy its
// positions, so that the sides of an edge have the same bits.
// On a seam: attached, the lowest outside patch owns it; detached, each side has an owner of its
// own. Normals are not shared.
//
// No point is both read and written: within a vertex or edge only the owner is read, and each
// patch's corner or edge belongs to one of them. So a backend may copy in any order, all at once.
//
// Threads  immutable after construction
#ifndef LATTICED_CORE_FFD_SHARED_POINTS_H_
#define LATTICED_CORE_FFD_SHARED_POINTS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/ffd/deform_plan.h"

namespace latticed {

inline constexpr uint8_t kFirstEdgeSlot = 3;

// A corner (slot 0..2) or the inner points of an edge (slot 3..5) that one patch takes from
// another.
struct SharedCopy {
  uint32_t from_patch = 0, to_patch = 0;
  uint8_t from_slot = 0, to_slot = 0;
  bool reversed = false;  // the edges run in opposite directions
};

// A patch's use of a plan vertex (slot 0..2) or edge (slot 3..5).
struct PointUse {
  uint32_t patch = 0;
  uint8_t slot = 0;
  bool reversed = false;  // the edge runs against its canonical order
};

class SharedPoints {
 public:
  struct SeamCopy {
    uint32_t seam = 0;
    SharedCopy copy;
  };
  // A use without an owner patch. It is evaluated from the lattice itself, in the same way on every
  // side.
  struct Orphan {
    PointUse use;
    uint32_t entity = 0;       // index of the vertex or edge, as the slot says
    uint32_t seam = kNoIndex;  // evaluated only while detached
  };

  explicit SharedPoints(const DeformPlan& plan);

  std::span<const SharedCopy> always() const { return always_; }
  std::span<const SeamCopy> when_attached() const { return when_attached_; }
  std::span<const SeamCopy> when_detached() const { return when_detached_; }
  std::span<const Orphan> orphans() const { return orphans_; }
  size_t MemoryBytes() const;

 private:
  std::vector<SharedCopy> always_;
  std::vector<SeamCopy> when_attached_;
  std::vector<SeamCopy> when_detached_;
  std::vector<Orphan> orphans_;

  friend class SharedPointsBuilder;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_SHARED_POINTS_H_
