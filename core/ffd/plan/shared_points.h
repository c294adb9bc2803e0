// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which patch owns each point that patches share, for pipelines that evaluate every patch by itself.
//
// Each plan vertex, and each plan edge without its ends, has one owner: the lowest patch of its owner box that uses it.
// All other patches copy the owner's positions, so that the sides of an edge have the same bits. Where no patch of that
// box uses it, the lattice itself is evaluated (Orphan). On an attached seam, the lowest outside patch is the owner. On
// a detached seam, each side has its own owner. Normals are not shared.
//
// No point is both read and written. Among the patches that use a vertex or edge, only the owner is read, and each
// corner or edge of a patch is a use of one vertex or edge. A backend may therefore copy in any order, or all at once.
//
// Threads  immutable after construction
#ifndef LATTICED_CORE_FFD_PLAN_SHARED_POINTS_H_
#define LATTICED_CORE_FFD_PLAN_SHARED_POINTS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"

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
  // The other chunks (core/base/limits.h) with a patch that owns a point of this chunk's patches; ascending.
  [[nodiscard]] std::span<const uint32_t> OwnerChunks(size_t chunk) const;
  size_t MemoryBytes() const;

 private:
  void ListOwners(size_t chunk_count);

  std::vector<SharedCopy> always_;
  std::vector<SeamCopy> when_attached_;
  std::vector<SeamCopy> when_detached_;
  std::vector<Orphan> orphans_;
  std::vector<uint32_t> owner_chunks_, owner_begin_;  // of chunk c: from owner_begin_[c] to [c + 1]

  friend class SharedPointsBuilder;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_SHARED_POINTS_H_
