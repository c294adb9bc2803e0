// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The search that cubes (fold_search.h) and triangles (triangle_search.h) share: whether a Bernstein polynomial is above 0
// everywhere in a cell.
//
//   every coefficient > slack   the cell is certified
//   a corner's value <= 0       the polynomial is 0 or less there
//   neither                     the cell is halved, and the half with the lesser coefficient is looked at first
//
// After kMostCells cells, or kMostHalvings halvings of one, the whole is undecided: the polynomial touches 0 within the
// slack, or nearly so.
//
// Errors   none; a polynomial with NaN is undecided
// Threads  pure function
#ifndef LATTICED_CORE_FOLDS_CELL_SEARCH_H_
#define LATTICED_CORE_FOLDS_CELL_SEARCH_H_

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/folds/box_determinant.h"
#include "core/folds/fold_report.h"

namespace latticed {

inline constexpr int kMostCells = 256;
inline constexpr size_t kMostOpenCells = static_cast<size_t>(kMostHalvings) + 1;

// `cells` has room for kMostOpenCells; the first one is the whole. look(cell, decision) keeps the least value that it sees at
// a corner, and returns whether it is 0 or less. halve(cell, second) makes halves of a cell. Sets state and cells of the
// decision; returns the cell that is folded, or null.
template <typename Cell, typename Decision, typename Look, typename Halve>
const Cell* SearchCells(std::vector<Cell>& cells, double slack, Decision& decision, Look look,
                        Halve halve) {
  size_t open = 1;
  while (open > 0) {
    Cell& cell = cells[open - 1];
    if (decision.cells++ == kMostCells) break;
    const double least = cell.polynomial.Least();
    if (least > slack) {
      --open;
      continue;
    }
    if (look(cell, decision)) {
      decision.state = FoldState::kFolded;
      return &cell;
    }
    if (std::isnan(least)) break;
    if (cell.halvings == kMostHalvings) {
      decision.state = FoldState::kUndecided;
      --open;
      continue;
    }
    Cell& second = cells[open++];
    halve(cell, second);
    second.halvings = ++cell.halvings;
    if (cell.polynomial.Least() < second.polynomial.Least()) std::swap(cell, second);
  }
  if (open > 0) decision.state = FoldState::kUndecided;
  return nullptr;
}

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_CELL_SEARCH_H_
