// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/fold_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/folds/box_determinant.h"

namespace latticed {
namespace {

constexpr size_t kMostOpen = static_cast<size_t>(kMostHalvings) + 1;

}  // namespace

FoldSearch::FoldSearch() : cells_(kMostOpen) {}

// Whether a corner of the cell has a value of 0 or less. Keeps the least value seen.
bool FoldSearch::Look(const Cell& cell, FoldDecision& decision) const {
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
  size_t open = 1;
  FoldDecision decision{.value = std::numeric_limits<double>::infinity(), .cells = 0};
  while (open > 0) {
    Cell& cell = cells_[open - 1];
    if (decision.cells++ == kMostCells) break;
    const double least = cell.polynomial.Least();
    if (least > slack) {
      --open;
      continue;
    }
    if (Look(cell, decision)) {
      decision.state = FoldState::kFolded;
      return MoveInside(cell, decision);
    }
    if (std::isnan(least)) break;
    if (cell.halvings == kMostHalvings) {
      decision.state = FoldState::kUndecided;
      --open;
      continue;
    }
    Cell& upper = cells_[open++];
    const size_t axis = cell.polynomial.SteepestAxis();
    cell.polynomial.Halve(axis, upper.polynomial);
    cell.width[static_cast<int>(axis)] *= 0.5;
    upper.lower = cell.lower;
    upper.lower[static_cast<int>(axis)] += cell.width[static_cast<int>(axis)];
    upper.width = cell.width;
    upper.halvings = ++cell.halvings;
    if (cell.polynomial.Least() < upper.polynomial.Least()) std::swap(cell, upper);
  }
  if (open > 0) decision.state = FoldState::kUndecided;
  return decision;
}

}  // namespace latticed
