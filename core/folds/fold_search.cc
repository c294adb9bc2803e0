// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/fold_search.h"

#include <algorithm>
#include <limits>

#include "core/folds/cell_search.h"

namespace latticed {

FoldSearch::FoldSearch() : cells_(kMostOpenCells) {}

// Whether a corner of the cell has a value of 0 or less. Keeps the least value seen.
bool FoldSearch::Look(const Cell& cell, FoldDecision& decision) {
  for (unsigned corner = 0; corner < 8; ++corner) {
    const double value = cell.polynomial.Corner(corner);
    if (!(value < decision.value)) continue;
    decision.value = value;
    decision.place = cell.lower;
    for (int axis = 0; axis < 3; ++axis) {
      if (((corner >> axis) & 1u) != 0) decision.place[axis] += cell.width[axis];
    }
  }
  return decision.value <= 0;
}

// A corner of a cube is shared with its neighbours, whose polynomials differ. Whoever evaluates there may be told another
// one. If a point inside is folded too, it is the better witness.
FoldDecision FoldSearch::MoveInside(const Cell& cell, FoldDecision decision) const {
  const Vec3d centre = cell.lower + 0.5 * cell.width;
  constexpr double kLeastStep = 0x1p-12;
  for (double step = 1; step >= kLeastStep; step *= 0.5) {
    const Vec3d place = decision.place + step * (centre - decision.place);
    const double value = whole_.Value(place);
    if (value <= 0) return {FoldState::kFolded, place, value, decision.cells};
  }
  return decision;
}

FoldDecision FoldSearch::Decide(double slack) {
  Cell& first = cells_[0];
  first.polynomial.count = whole_.count;
  std::copy_n(whole_.coefficients.begin(), whole_.size(), first.polynomial.coefficients.begin());
  first.lower = {};
  first.width = {1, 1, 1};
  first.halvings = 0;
  FoldDecision decision{.value = std::numeric_limits<double>::infinity(), .cells = 0};
  const auto look = [](const Cell& cell, FoldDecision& least) { return Look(cell, least); };
  const auto halve = [](Cell& cell, Cell& upper) {
    const size_t steepest = cell.polynomial.SteepestAxis();
    const auto axis = static_cast<int>(steepest);
    cell.polynomial.Halve(steepest, upper.polynomial);
    cell.width[axis] *= 0.5;
    upper.lower = cell.lower;
    upper.lower[axis] += cell.width[axis];
    upper.width = cell.width;
  };
  const Cell* const folded = SearchCells(cells_, slack, decision, look, halve);
  return folded == nullptr ? decision : MoveInside(*folded, decision);
}

}  // namespace latticed
