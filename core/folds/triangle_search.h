// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decides whether a Bernstein polynomial is above 0 everywhere on a triangle. The search is that of cell_search.h; a triangle
// is halved each time at another edge.
//
// Errors   none; a polynomial with NaN is undecided
// Threads  one at a time: the search keeps its memory from triangle to triangle
#ifndef LATTICED_CORE_FOLDS_TRIANGLE_SEARCH_H_
#define LATTICED_CORE_FOLDS_TRIANGLE_SEARCH_H_

#include <array>
#include <vector>

#include "core/folds/bernstein_triangle.h"
#include "core/folds/fold_report.h"

namespace latticed {

struct TriangleDecision {
  FoldState state = FoldState::kCertified;
  // Unless certified: where the value is 0 or less, or else the least that was seen.
  std::array<double, 3> barycentrics{};
  double value = 0;
  int cells = 0;  // looked at
};

class TriangleSearch {
 public:
  TriangleSearch();
  // The polynomial of the next triangle, to be filled in before Decide.
  BernsteinTriangle& polynomial() { return whole_; }
  [[nodiscard]] TriangleDecision Decide(double slack);

 private:
  using Corners = std::array<std::array<double, 3>, 3>;  // barycentrics
  struct Cell {
    BernsteinTriangle polynomial;
    Corners corners;
    int halvings = 0;
  };

  [[nodiscard]] static bool Look(const Cell& cell, TriangleDecision& decision);
  [[nodiscard]] TriangleDecision MoveInside(const TriangleDecision& decision) const;

  BernsteinTriangle whole_;
  std::vector<Cell> cells_;  // a stack: all cells that are not decided yet
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_TRIANGLE_SEARCH_H_
