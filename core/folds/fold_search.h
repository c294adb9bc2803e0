// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decides whether a Bernstein polynomial is above 0 everywhere in the unit cube.
//
//   every coefficient > slack   the cell is certified
//   a corner's value <= 0       the polynomial is 0 or less there
//   neither                     the cell is halved along its steepest axis, and the half with the lesser coefficient is
//                               looked at first
//
// After kMostCells cells, or kMostHalvings halvings of one, the cube is undecided: the polynomial touches 0 within the
// slack, or nearly so. In 10,000 random lattices no box needed more than tests/bench/results/folds.md says.
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
  static constexpr int kMostCells = 256;

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

  [[nodiscard]] bool Look(const Cell& cell, FoldDecision& decision) const;
  [[nodiscard]] FoldDecision MoveInside(const Cell& cell, FoldDecision decision) const;

  BernsteinVolume whole_;
  std::vector<Cell> cells_;  // a stack: all cells that are not decided yet
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_FOLD_SEARCH_H_
