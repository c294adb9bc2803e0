// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/triangle_search.h"

#include <limits>

#include "core/folds/cell_search.h"

namespace latticed {
namespace {

// a + share (b - a)
std::array<double, 3> Toward(const std::array<double, 3>& a, const std::array<double, 3>& b,
                             double share) {
  std::array<double, 3> result;
  for (size_t c = 0; c < 3; ++c) result[c] = a[c] + share * (b[c] - a[c]);
  return result;
}

}  // namespace

TriangleSearch::TriangleSearch() : cells_(kMostOpenCells) {}

// Whether a corner of the cell has a value of 0 or less. Keeps the least value seen.
bool TriangleSearch::Look(const Cell& cell, TriangleDecision& decision) {
  for (size_t corner = 0; corner < 3; ++corner) {
    const double value = cell.polynomial.Corner(corner);
    if (!(value < decision.value)) continue;
    decision.value = value;
    decision.barycentrics = cell.corners[corner];
  }
  return decision.value <= 0;
}

// On an edge of the patch, a neighbour has another J. If a point inside is folded too, it is the better witness.
TriangleDecision TriangleSearch::MoveInside(const TriangleDecision& decision) const {
  constexpr std::array<double, 3> kCentre{1.0 / 3, 1.0 / 3, 1.0 / 3};
  constexpr double kLeastStep = 0x1p-12;
  for (double step = 0.5; step >= kLeastStep; step *= 0.5) {
    const auto place = Toward(decision.barycentrics, kCentre, step);
    const double value = whole_.Value(place);
    if (value <= 0) return {FoldState::kFolded, place, value, decision.cells};
  }
  return decision;
}

TriangleDecision TriangleSearch::Decide(double slack) {
  Cell& first = cells_[0];
  whole_.CopyTo(first.polynomial);
  first.corners = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  first.halvings = 0;
  TriangleDecision decision{.value = std::numeric_limits<double>::infinity()};
  const auto look = [](const Cell& cell, TriangleDecision& least) { return Look(cell, least); };
  const auto halve = [](Cell& cell, Cell& second) {
    const Corners& c = cell.corners;
    const auto middle = Toward(c[0], c[1], 0.5);
    cell.polynomial.Halve(second.polynomial);
    second.corners = {c[1], c[2], middle};
    cell.corners = Corners{c[2], c[0], middle};
  };
  const bool is_folded = SearchCells(cells_, slack, decision, look, halve) != nullptr;
  return is_folded ? MoveInside(decision) : decision;
}

}  // namespace latticed
