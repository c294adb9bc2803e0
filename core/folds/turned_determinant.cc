// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/turned_determinant.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/folds/box_slopes.h"

namespace latticed {
namespace {

constexpr double kUnknown = -1;

double TurnedSlack(double condition, bool is_weighted = false) {
  return 6 * ((is_weighted ? 2500 : 2200) + 20 * condition) * 0x1p-53;
}

// The number of knot spans of an axis, empty ones included.
size_t SpanCount(const LatticeStructure& s, size_t axis) {
  return static_cast<size_t>(s.size[axis] - s.degree[axis]);
}
size_t SpanCount(const LatticeStructure& s) {
  return SpanCount(s, 0) * SpanCount(s, 1) * SpanCount(s, 2);
}
size_t PlaceOfSpans(const LatticeStructure& s, const KnotSpans& spans) {
  const auto at = [&](size_t a) { return static_cast<size_t>(spans[a] - s.degree[a]); };
  return at(0) + SpanCount(s, 0) * (at(1) + SpanCount(s, 1) * at(2));
}

// The same polynomial, by forms of a higher degree: times (b0 + b1 + b2)^steps.
VectorForm Elevated(const VectorForm& vector, size_t degree) {
  const size_t steps = degree - vector[0].degree();
  if (steps == 0) return vector;
  TriangleForm one(steps);
  for (size_t i = 0; i <= steps; ++i) {
    for (size_t j = 0; i + j <= steps; ++j) one.at(i, j) = Multinomial(i, j, steps - i - j);
  }
  VectorForm result = MakeVectorForm(degree);
  for (size_t c = 0; c < 3; ++c) result[c].AddProduct(one, vector[c], 1);
  return result;
}

// to += factor * from
void AddScaled(const TriangleForm& from, double factor, TriangleForm& to) {
  const size_t n = from.degree();
  for (size_t i = 0; i <= n; ++i) {
    for (size_t j = 0; i + j <= n; ++j) to.at(i, j) += factor * from.at(i, j);
  }
}

// to += value
void AddConstant(double value, TriangleForm& to) {
  const size_t n = to.degree();
  for (size_t i = 0; i <= n; ++i) {
    for (size_t j = 0; i + j <= n; ++j) to.at(i, j) += value * Multinomial(i, j, n - i - j);
  }
}

// Corners are in their boxes up to rounding; the slack has room for this much.
bool AreInBox(const TriangleInBox& corners) {
  constexpr double kMost = 0x1p-30;
  return std::ranges::all_of(corners, [](const std::array<double, 3>& axis) {
    return std::ranges::all_of(axis, [](double l) { return l >= -kMost && l <= 1 + kMost; });
  });
}

}  // namespace

TurnedPatches::Lattice TurnedPatches::MakeLattice(const LatticeStructure& structure,
                                                  std::span<const Vec3d> points,
                                                  std::span<const Vec3d> offsets) {
  Lattice lattice{.structure = &structure,
                  .points = points,
                  .offsets = offsets,
                  .frame = FrameGradients(structure.frame)};
  lattice.rises.assign(SpanCount(structure), kUnknown);
  if (!offsets.empty()) lattice.reaches.assign(SpanCount(structure), kUnknown);
  return lattice;
}

TurnedPatches::TurnedPatches(const DeformPlan& plan, std::span<const Vec3d> control_points,
                             std::span<const Vec3d> offsets)
    : plan_(plan) {
  lattices_.push_back(MakeLattice(plan.structure, control_points, offsets));
  for (const TurnedLattice& one : plan.turned) {
    lattices_.push_back(
        MakeLattice(one.structure, control_points.subspan(one.first_point),
                    offsets.empty() ? std::span<const Vec3d>() : offsets.subspan(one.first_point)));
  }
}

bool TurnedPatches::IsReached(const DeformPlan& plan, size_t patch) {
  return std::ranges::any_of(
      plan.turned, [&](const TurnedLattice& one) { return one.spans[patch] != kNoSpans; });
}

size_t TurnedPatches::MostBytes(const DeformPlan& plan) {
  size_t spans = SpanCount(plan.structure);
  for (const TurnedLattice& one : plan.turned) spans += SpanCount(one.structure);
  const size_t numbers = plan.is_weighted() ? 2 : 1;  // a box
  return (1 + plan.turned.size()) * sizeof(Lattice) + spans * numbers * sizeof(double);
}

KnotSpans TurnedPatches::SpansOf(size_t lattice, size_t patch) const {
  if (lattice > 0) return plan_.turned[lattice - 1].spans[patch];
  const uint32_t box = plan_.patches[patch].box;
  return box == plan_.outside_box() ? kNoSpans : plan_.boxes[box].span;
}

// In the box with the patch's spans.
TriangleInBox TurnedPatches::CornersOf(size_t lattice, size_t patch) const {
  const LatticeStructure& s = *lattices_[lattice].structure;
  const KnotSpans spans = SpansOf(lattice, patch);
  TriangleInBox corners;
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t v = plan_.patches[patch].vertex[c];
    const Vec3d at =
        lattice == 0 ? plan_.vertices[v].parameter : plan_.turned[lattice - 1].parameters[v];
    for (size_t a = 0; a < 3; ++a) {
      const auto span = static_cast<size_t>(spans[a]);
      const double lower = s.knots[a][span], upper = s.knots[a][span + 1];
      corners[a][c] = (at[static_cast<int>(a)] - lower) / (upper - lower);
    }
  }
  return corners;
}

void TurnedPatches::Enter(Lattice& lattice, const KnotSpans& spans) {
  if (lattice.spans == spans) return;
  lattice.spans = spans;
  const LatticeStructure& s = *lattice.structure;
  lattice.box = SlopesOfBox(s, lattice.points, spans);
  if (lattice.offsets.empty()) return;
  const BoxPart part = WholeBox(s, spans);
  lattice.offset = RestrictVolume(s, lattice.offsets, spans, part.lower, part.upper);
  lattice.most_offset = LargestPoint(ControlBox(s, lattice.offsets, spans), LargestComponent);
}

// A bound of |G_g| in the box that the lattice has entered, rounding included.
double TurnedPatches::ReachOf(const Lattice& lattice) {
  constexpr double kRounding = 140 * 0x1p-53;  // 67 u per component
  return LargestPoint(lattice.offset, Norm) + kRounding * lattice.most_offset;
}

bool TurnedPatches::IsNearRest(size_t patch) {
  constexpr double kSurely = 0.999;  // far from what rounding of the sum can do
  double rises = 0, reaches = 0;
  for (size_t g = 0; g < lattices_.size(); ++g) {
    const KnotSpans spans = SpansOf(g, patch);
    if (spans == kNoSpans) continue;
    Lattice& lattice = lattices_[g];
    const size_t box = PlaceOfSpans(*lattice.structure, spans);
    double& rise = lattice.rises[box];
    if (rise == kUnknown) {
      Enter(lattice, spans);
      rise = lattice.box.RiseOver(lattice.structure->frame, lattice.frame);
      if (plan_.is_weighted()) lattice.reaches[box] = ReachOf(lattice);
    }
    if (!AreInBox(CornersOf(g, patch))) return false;
    rises += rise;
    if (plan_.is_weighted()) reaches += lattice.reaches[box];
  }
  if (!plan_.is_weighted()) return rises < kSurely;
  return std::ranges::max(plan_.CornerWeights(patch)) * rises +
             Norm(plan_.PatchWeightGradient(patch)) * reaches <
         kSurely;
}

std::array<VectorForm, 3> TurnedPatches::Columns(const Lattice& lattice,
                                                 const TriangleInBox& corners, Vec3d& bounds) {
  const auto degree = static_cast<size_t>(lattice.structure->patch_degree()) - 1;
  std::array<VectorForm, 3> columns{MakeVectorForm(degree), MakeVectorForm(degree),
                                    MakeVectorForm(degree)};
  for (size_t a = 0; a < 3; ++a) {
    const VectorForm slope = Compose(lattice.box.slopes[a], corners);
    const Vec3d gradient = lattice.frame.gradients[a] / lattice.box.widths[a];
    for (size_t axis = 0; axis < 3; ++axis) {
      for (size_t c = 0; c < 3; ++c) {
        AddScaled(slope[c], gradient[static_cast<int>(axis)], columns[axis][c]);
      }
    }
    bounds += (lattice.box.most[a] / lattice.box.widths[a]) * lattice.frame.sizes[a];
  }
  return columns;
}

void TurnedPatches::Weigh(size_t patch, std::span<const size_t> lattices,
                          std::array<VectorForm, 3>& column, Vec3d& bounds) const {
  const size_t n = column[0][0].degree() + 1;
  const TriangleForm weight = LinearForm(plan_.CornerWeights(patch));
  const Vec3d gradient = plan_.PatchWeightGradient(patch);
  VectorForm offset = MakeVectorForm(n);
  double most = 0;
  for (const size_t g : lattices) {
    const VectorForm own = Elevated(Compose(lattices_[g].offset, CornersOf(g, patch)), n);
    for (size_t c = 0; c < 3; ++c) AddScaled(own[c], 1, offset[c]);
    most += lattices_[g].most_offset;
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    const double slope = gradient[static_cast<int>(axis)];
    VectorForm weighted = MakeVectorForm(n);
    for (size_t c = 0; c < 3; ++c) {
      weighted[c].AddProduct(weight, column[axis][c], 1);
      AddScaled(offset[c], slope, weighted[c]);
    }
    AddConstant(1, weighted[axis]);
    column[axis] = std::move(weighted);
    bounds[static_cast<int>(axis)] += 1 + std::abs(slope) * most;
  }
}

double TurnedPatches::MakeDeterminant(size_t patch, BernsteinTriangle& determinant) {
  std::vector<size_t> present;
  size_t degree = 0;
  for (size_t g = 0; g < lattices_.size(); ++g) {
    if (SpansOf(g, patch) == kNoSpans) continue;
    present.push_back(g);
    degree = std::max(degree, static_cast<size_t>(lattices_[g].structure->patch_degree()) - 1);
  }
  std::array<VectorForm, 3> column{MakeVectorForm(degree), MakeVectorForm(degree),
                                   MakeVectorForm(degree)};
  // J without the J_g: the identity, less one for each of them. With weights the identity comes later.
  const double rest = (plan_.is_weighted() ? 0 : 1) - static_cast<double>(present.size());
  for (size_t axis = 0; axis < 3; ++axis) AddConstant(rest, column[axis][axis]);
  Vec3d bounds{std::abs(rest), std::abs(rest), std::abs(rest)};
  double condition = 1;
  bool is_sure = true;
  for (const size_t g : present) {
    Lattice& lattice = lattices_[g];
    Enter(lattice, SpansOf(g, patch));
    const TriangleInBox corners = CornersOf(g, patch);
    is_sure = is_sure && AreInBox(corners);
    condition = std::max(condition, lattice.frame.condition);
    const std::array<VectorForm, 3> own = Columns(lattice, corners, bounds);
    for (size_t axis = 0; axis < 3; ++axis) {
      const VectorForm elevated = Elevated(own[axis], degree);
      for (size_t c = 0; c < 3; ++c) AddScaled(elevated[c], 1, column[axis][c]);
    }
  }
  if (plan_.is_weighted()) Weigh(patch, present, column, bounds);
  SetDeterminant(column, 1, determinant);
  if (!is_sure) return std::numeric_limits<double>::infinity();
  return TurnedSlack(condition, plan_.is_weighted()) * bounds.x * bounds.y * bounds.z;
}

}  // namespace latticed
