// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The order of patches in a chunk, and which of its corners a patch begins with.
//
// A Draco stream codes each point by its difference from the one before it. A patch is a path from corner 0, along the
// edge to corner 1 and back in rows, to corner 2. Many steps are along that edge, so it should be short; and the next
// patch should begin near corner 2. A chain takes, again and again, the patch and the rotation of least cost:
//
//   cost    bits(corner 2 of the last patch, corner 0) + 2 bits(corner 0, corner 1) + bits(corner 1, corner 2)
//   bits    ⌈2 log2 m⌉ or one more, m the largest difference of two points' coordinates at rest, in 2^-14 of the
//           mesh's extent; 0 for the same point
//
// An edge may come first where both of its angles are at most right, or where it is the longest. The patch then lies
// over that edge, and the frame in which backends evaluate it is accurate (core/cpu/fused/kernel/fused_kernel.h).
// An edge shorter than 1/16 of the longest may not: rounding may turn it.
//
// Costs are integers, and ties go to the first in the order that was given, so each machine makes the same chain.
// Threads  not thread-safe
#ifndef LATTICED_CORE_FFD_PLAN_PATCH_CHAIN_H_
#define LATTICED_CORE_FFD_PLAN_PATCH_CHAIN_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/bounds.h"
#include "core/base/limits.h"
#include "core/ffd/plan/knot_split.h"

namespace latticed {

struct ChainedPiece {
  uint32_t piece = 0;   // index into SplitMesh::pieces
  uint32_t corner = 0;  // of the piece, 0 to 2; it is corner 0 of the patch
};

class PatchChain {
 public:
  // The mesh must outlive the chain.
  PatchChain(const SplitMesh& split, const Bounds& mesh_bounds);

  // Reads the corners of the next piece of the mesh. Neighbours in the mesh share vertices, those in a chain are far
  // apart in memory; so pieces are read here, before they are put in order.
  void AddPiece();
  // Begins another chunk: its first patch comes after nothing.
  void BeginChunk() { last_.reset(); }
  // Appends `pieces`, which have been added: those of one chunk and one knot box, at most kPatchesPerChunk.
  void Append(std::span<const uint32_t> pieces, std::vector<ChainedPiece>& chain);

 private:
  static constexpr size_t kMostPieces = limits::kPatchesPerChunk;
  static constexpr uint8_t kForbidden = 255;  // more than any cost

  using GridPoint = std::array<uint16_t, 3>;

  struct Candidate {
    std::array<GridPoint, 3> corners{};
    // By the corner that comes first: the cost without the way to it. kForbidden where it may not.
    std::array<uint8_t, 3> inner_cost{};
  };

  // Pieces that are not in the chain yet. Each has three columns, one for each corner that may come first.
  struct Open {
    void Remove(size_t piece);

    size_t count = 0;
    std::array<size_t, kMostPieces> place{};                 // by piece, as they were given
    std::array<std::array<float, 3 * kMostPieces>, 3> at{};  // by axis and column
    // Its inner cost, and below that which column it was at first. Signed, which old machines compare sooner.
    std::array<int32_t, 3 * kMostPieces> key{};
  };

  int32_t LeastKey() const;

  const SplitMesh& split_;
  const Vec3d origin_;
  double scale_ = 0;
  std::vector<Candidate> candidates_;  // by piece
  std::optional<GridPoint> last_;
  Open open_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_PATCH_CHAIN_H_
