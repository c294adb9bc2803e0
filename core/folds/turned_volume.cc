// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/turned_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/dirty_set.h"
#include "core/folds/box_slopes.h"

namespace latticed {
namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();
constexpr int kMostVolumeHalvings = 60;
// Of a cell: more are not bounded, but halved.
constexpr size_t kMostChoices = 128;

// The cells are a heap, with the least bound first. A bound that is not a number is the least.
constexpr auto kIsLater = [](const auto& a, const auto& b) {
  return std::isnan(b.least) ? !std::isnan(a.least) : a.least > b.least;
};

// Calls visit(span) for each knot box of the lattice.
template <typename Visit>
absl::Status ForEachBox(const LatticeStructure& s, Visit visit) {
  const auto is_empty = [&](size_t a, int span) {
    const auto at = static_cast<size_t>(span);
    return !(s.knots[a][at + 1] > s.knots[a][at]);
  };
  for (int w = s.degree[2]; w < s.size[2]; ++w) {
    for (int v = s.degree[1]; v < s.size[1]; ++v) {
      for (int u = s.degree[0]; u < s.size[0]; ++u) {
        if (is_empty(0, u) || is_empty(1, v) || is_empty(2, w)) continue;
        LATTICED_RETURN_IF_ERROR(visit(std::array<int, 3>{u, v, w}));
      }
    }
  }
  return absl::OkStatus();
}

std::vector<VolumeLattice> LatticesOf(const DeformPlan& plan, std::span<const Vec3d> points) {
  std::vector<VolumeLattice> lattices;
  lattices.reserve(1 + plan.turned.size());
  const auto add = [&](const LatticeStructure& s, size_t first) {
    const auto count = static_cast<size_t>(s.control_point_count());
    lattices.emplace_back(s, points.subspan(first, count),
                          std::span(plan.identity_points).subspan(first, count));
  };
  add(plan.structure, 0);
  for (const TurnedLattice& one : plan.turned) add(one.structure, one.first_point);
  return lattices;
}

}  // namespace

TurnedVolume::TurnedVolume(const DeformPlan& plan, std::span<const Vec3d> control_points)
    : plan_(plan), control_points_(control_points), lattices_(LatticesOf(plan, control_points)) {}

bool TurnedVolume::ReachesOutside(const DeformPlan& plan) {
  for (const TurnedLattice& one : plan.turned) {
    for (unsigned corner = 0; corner < 8; ++corner) {
      Vec3d at = one.structure.frame.origin;
      for (size_t a = 0; a < 3; ++a) {
        if (((corner >> a) & 1u) != 0) at += one.structure.frame.edges[a];
      }
      if (!FindVolumePlace(plan.structure, at).has_value()) return true;
    }
  }
  return false;
}

size_t TurnedVolume::MostBytes(const DeformPlan& plan) {
  size_t bytes = VolumeLattice::MostBytes(plan.structure);
  for (const TurnedLattice& one : plan.turned) bytes += VolumeLattice::MostBytes(one.structure);
  const size_t pieces = kMostChoices * (1 + plan.turned.size());
  return bytes + pieces * sizeof(VolumePiece) + kMostVolumeCells * sizeof(Cell);
}

std::vector<bool> TurnedVolume::InfluencedBoxes(const DeformPlan& plan,
                                                std::span<const uint32_t> indices) {
  const auto own_count = static_cast<uint32_t>(plan.structure.control_point_count());
  std::vector<uint32_t> own;
  // Control points that differ from those at rest where an index names one.
  std::vector<Vec3d> marked = plan.identity_points;
  bool is_turned = false;
  for (const uint32_t index : indices) {
    if (index < own_count) {
      own.push_back(index);
    } else {
      marked[index].x += 1 + std::abs(marked[index].x);
      is_turned = true;
    }
  }
  std::vector<bool> boxes = latticed::InfluencedBoxes(plan, own);
  if (!is_turned) return boxes;
  const TurnedVolume changes(plan, marked);
  for (uint32_t box = 0; box < plan.outside_box(); ++box) {
    if (changes.IsReached(box)) boxes[box] = true;
  }
  boxes[plan.outside_box()] = true;
  return boxes;
}

bool TurnedVolume::IsReached(uint32_t box) const {
  const KnotBox& knots = plan_.boxes[box];
  const WorldCell cell = lattices_[0].CellBetween(knots.lower, knots.upper);
  return std::any_of(lattices_.begin() + 1, lattices_.end(), [&](const VolumeLattice& lattice) {
    return lattice.Moves(lattice.Look(cell));
  });
}

VolumeDecision TurnedVolume::DecideBox(uint32_t box) {
  const KnotBox& knots = plan_.boxes[box];
  return Decide({.span = knots.span, .lower = knots.lower, .upper = knots.upper});
}

absl::StatusOr<VolumeDecision> TurnedVolume::DecideOutside(StopCheck stop) {
  VolumeDecision worst;
  for (size_t g = 1; g < lattices_.size(); ++g) {
    const LatticeStructure& s = lattices_[g].structure();
    LATTICED_RETURN_IF_ERROR(ForEachBox(s, [&](const std::array<int, 3>& span) -> absl::Status {
      if (worst.state == FoldState::kFolded || !lattices_[g].Moves(span)) return absl::OkStatus();
      const BoxPart box = WholeBox(s, span);
      const WorldCell cell = lattices_[g].CellBetween(box.lower, box.upper);
      if (!lattices_[0].Look(cell).leaves) return absl::OkStatus();
      LATTICED_RETURN_IF_ERROR(stop());
      const VolumeDecision decision =
          Decide({.of = g, .span = span, .lower = box.lower, .upper = box.upper});
      if (decision.state > worst.state) worst = decision;
      return absl::OkStatus();
    }));
  }
  return worst;
}

// Looks at the cells with the least bounds first.
VolumeDecision TurnedVolume::Decide(const Cell& whole) {
  VolumeDecision decision{.determinant = std::numeric_limits<double>::infinity()};
  if (IsNearRest(whole)) return decision;
  std::vector<Cell> cells{whole};
  const auto is_folded = [&](Cell& cell) {
    ++decision.cells;
    Bound(cell);
    return !(cell.least > 0) && Look(cell, decision);
  };
  const auto end = [&decision](FoldState state) {
    decision.state = state;
    return decision;
  };
  if (is_folded(cells[0])) return end(FoldState::kFolded);
  if (cells[0].least > 0) return decision;
  while (!cells.empty()) {
    std::ranges::pop_heap(cells, kIsLater);
    Cell lower = cells.back();
    cells.pop_back();
    if (decision.cells >= kMostVolumeCells || std::isnan(lower.least)) {
      return end(FoldState::kUndecided);
    }
    if (lower.halvings == kMostVolumeHalvings) {
      decision.state = FoldState::kUndecided;
      continue;
    }
    ++lower.halvings;
    Cell upper = lower;
    const int axis = lower.axis;
    upper.lower[axis] = lower.upper[axis] = 0.5 * (lower.lower[axis] + lower.upper[axis]);
    for (Cell* const half : {&lower, &upper}) {
      if (is_folded(*half)) return end(FoldState::kFolded);
      if (half->least > 0) continue;
      cells.push_back(*half);
      std::ranges::push_heap(cells, kIsLater);
    }
  }
  return decision;
}

bool TurnedVolume::IsNearRest(const Cell& cell) {
  constexpr double kSurely = 0.999;  // far from what rounding of the sum can do
  const WorldCell world = lattices_[cell.of].CellBetween(cell.lower, cell.upper);
  double rises = 0;
  for (size_t g = cell.of == 0 ? 0 : 1; g < lattices_.size(); ++g) {
    VolumeLattice::View view = lattices_[g].Look(world);
    if (g == cell.of) view.first = view.last = cell.span;
    rises += lattices_[g].Rise(view);
  }
  return rises < kSurely;
}

void TurnedVolume::Bound(Cell& cell) {
  const WorldCell world = lattices_[cell.of].CellBetween(cell.lower, cell.upper);
  const double rest = Dot(world.half[0], Cross(world.half[1], world.half[2]));
  JacobianForm form{.centre = world.half, .slope = {}, .bend = {}};
  Vec3d crossed;
  std::vector<VolumeLattice::View> views;
  size_t choices = 1;
  for (size_t g = 0; g < lattices_.size(); ++g) {
    const VolumeLattice& lattice = lattices_[g];
    VolumeLattice::View& view = views.emplace_back(lattice.Look(world));
    if (g == 0 && cell.of != 0) continue;
    if (g != cell.of && !lattice.Moves(view)) view.meets = view.leaves = false;
    for (int k = 0; k < 3; ++k) {
      crossed[k] = std::max(crossed[k], lattice.Crossed(view, static_cast<size_t>(k)));
    }
    if (g == cell.of) continue;
    choices = std::min(choices * std::max<size_t>(1, lattice.PieceCount(view)), kMostChoices + 1);
  }
  cell.place = {};
  cell.least = -kNoBound;
  loss_ = crossed;
  if (choices <= kMostChoices) {
    form +=
        lattices_[cell.of].FormBetween(world, views[cell.of], cell.span, cell.lower, cell.upper);
    pieces_.clear();
    cell.least = kNoBound;
    if (cell.of != 0 && !views[0].leaves) return;  // inside the plan's own frame
    for (size_t g = 0; g < lattices_.size(); ++g) {
      if (g == cell.of) continue;
      std::vector<VolumePiece> pieces;
      if (g == 0) {
        lattices_[0].AddBeyond(views[0], pieces);
      } else if (views[g].meets) {
        lattices_[g].AddPieces(world, views[g], pieces);
      }
      if (!pieces.empty()) pieces_.push_back(std::move(pieces));
    }
    planes_.clear();
    BoundChoices(0, form, rest, cell);
  }
  cell.axis = loss_.y > loss_.x ? 1 : 0;
  if (loss_.z > loss_[cell.axis]) cell.axis = 2;
}

void TurnedVolume::BoundChoices(size_t lattice, const JacobianForm& form, double rest, Cell& cell) {
  if (lattice == pieces_.size()) {
    const DeterminantBound bound = BoundDeterminant(form, rest, planes_);
    if (bound.least >= cell.least || std::isnan(cell.least)) return;
    cell.least = bound.least;
    cell.place = bound.place;
    loss_ = bound.loss;
    return;
  }
  for (const VolumePiece& piece : pieces_[lattice]) {
    JacobianForm sum = form;
    sum += piece.form;
    const size_t count = planes_.size();
    planes_.insert(planes_.end(), piece.planes.begin(),
                   piece.planes.begin() + static_cast<std::ptrdiff_t>(piece.plane_count));
    BoundChoices(lattice + 1, sum, rest, cell);
    planes_.resize(count);
  }
}

bool TurnedVolume::Look(const Cell& cell, VolumeDecision& decision) const {
  constexpr double kInside = 1 - 0x1p-10;  // of the cell, where its neighbours are not
  const Vec3d centre = 0.5 * (cell.lower + cell.upper), half = 0.5 * (cell.upper - cell.lower);
  const FrameMap map(lattices_[cell.of].structure());
  for (const Vec3d t : {Vec3d{}, kInside * cell.place}) {
    const Vec3d world = map.ToWorld(centre + Vec3d{half.x * t.x, half.y * t.y, half.z * t.z});
    const DeformedPoint point = EvaluateWorld(plan_, control_points_, world);
    if (point.inside != (cell.of == 0)) continue;
    const auto& j = point.jacobian;
    const double determinant = Dot(j[0], Cross(j[1], j[2]));
    if (determinant >= decision.determinant) continue;
    decision.determinant = determinant;
    decision.rest_point = world;
    if (determinant <= 0) return true;
  }
  return false;
}

}  // namespace latticed
