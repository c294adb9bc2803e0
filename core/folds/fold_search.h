// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decides whether a Bernstein polynomial is above 0 everywhere in the unit cube.
//
// The search is that of cell_search.h; a cell is halved along its steepest axis. In 10,000 random lattices no box needed more
// than tests/bench/results/folds.md says.
//
// Errors   none; a polynomial with NaN is undecided
// Threads  one at a time: the search keeps its memory from cube to cube
#ifndef LATTICED_CORE_FOLDS_FOLD_SEARCH_H_
#define LATTICED_CORE_FOLDS_FOLD_SEARCH_H_

#include <vector>

#include "core/base/vec.h"
#include "core/folds/bernstein_volume.h"
#include "core/folds/fold_report.h"

namespace latticed {

struct FoldDecision {
  FoldState state = FoldState::kCertified;
  // Unless certified: where the value is 0 or less, or else the least that was seen.
  Vec3d place;
  double value = 0;
  int cells = 1;  // looked at
};

class FoldSearch {
 public:
  FoldSearch();
  // The polynomial of the next cube, to be filled in before Decide.
  BernsteinVolume& polynomial() { return whole_; }
  [[nodiscard]] FoldDecision Decide(double slack);

 private:
  struct Cell {
    BernsteinVolume polynomial;
    Vec3d lower, width;
    int halvings = 0;
  };

  [[nodiscard]] static bool Look(const Cell& cell, FoldDecision& decision);
  [[nodiscard]] FoldDecision MoveInside(const Cell& cell, FoldDecision decision) const;

  BernsteinVolume whole_;
  std::vector<Cell> cells_;  // a stack: all cells that are not decided yet
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_FOLD_SEARCH_H_
