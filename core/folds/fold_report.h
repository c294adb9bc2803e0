// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where a deformation folds: det J <= 0, J the Jacobian of the deformed by the rest world (box_determinant.h).
//
// Threads  plain data
#ifndef LATTICED_CORE_FOLDS_FOLD_REPORT_H_
#define LATTICED_CORE_FOLDS_FOLD_REPORT_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

enum class FoldScope {
  kSurface,  // of each knot box the bounds of its patches at rest; with weights or turned lattices, its patches
  kVolume,  // all knot boxes; with turned lattices, all that one of their frames holds
};

// From better to worse.
enum class FoldState {
  kCertified,  // det J > 0 is proved everywhere in the box's part of the scope
  kUndecided,  // neither was found
  kFolded,     // at rest_point det J, in double, is 0 or less
};

// FoldedBox::place of the outside box.
inline constexpr std::array<int, 3> kOutsidePlace{-1, -1, -1};

// A box that is not certified.
struct FoldedBox {
  uint32_t box = 0;            // index in DeformPlan::boxes
  std::array<int, 3> place{};  // on each axis, from 0, among the knot intervals that are not empty
  FoldState state = FoldState::kFolded;
  Vec3d rest_point;        // in the world; of an undecided box, where the least det J was seen
  double determinant = 0;  // there

  friend bool operator==(const FoldedBox&, const FoldedBox&) = default;
};

struct FoldReport {
  uint64_t boxes = 0;             // that have a part in the scope
  std::vector<FoldedBox> places;  // by box, ascending

  [[nodiscard]] bool certified() const { return places.empty(); }
  [[nodiscard]] size_t Count(FoldState state) const;
  // Of a box that is not in the report: kCertified.
  [[nodiscard]] FoldState StateOf(uint32_t box) const;
  [[nodiscard]] size_t MemoryBytes() const { return places.capacity() * sizeof(FoldedBox); }

  friend bool operator==(const FoldReport&, const FoldReport&) = default;
};

// A box that `after` has in a worse state than `before`, or nullptr. Both are of the same plan and scope. Whatever becomes
// of a box that is folded already makes no new fold; a fold that grows into a neighbour does.
[[nodiscard]] const FoldedBox* NewFold(const FoldReport& before, const FoldReport& after);

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_FOLD_REPORT_H_
