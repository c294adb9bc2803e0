// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/volume_lattice.h"

#include <algorithm>
#include <cmath>

#include "core/ffd/plan/knot_split.h"
#include "core/folds/box_slopes.h"
#include "core/folds/linear_bound.h"

namespace latticed {
namespace {

constexpr double kUnknownRise = -1;

}  // namespace

VolumeLattice::VolumeLattice(const LatticeStructure& s, std::span<const Vec3d> points,
                             std::span<const Vec3d> at_rest)
    : structure_(s), points_(points), map_(s), frame_(s.frame) {
  size_t spans = 1;
  for (size_t a = 0; a < 3; ++a) spans *= static_cast<size_t>(s.size[a] - s.degree[a]);
  moved_.resize(spans);
  rises_.assign(spans, kUnknownRise);
  for (int k = 0, index = 0; k < s.size[2]; ++k) {
    for (int j = 0; j < s.size[1]; ++j) {
      for (int i = 0; i < s.size[0]; ++i, ++index) {
        if (points[static_cast<size_t>(index)] == at_rest[static_cast<size_t>(index)]) continue;
        const auto last = [&](int at, size_t a) {
          return std::min(at + s.degree[a], s.size[a] - 1);
        };
        for (int w = std::max(k, s.degree[2]); w <= last(k, 2); ++w) {
          for (int v = std::max(j, s.degree[1]); v <= last(j, 1); ++v) {
            for (int u = std::max(i, s.degree[0]); u <= last(i, 0); ++u) {
              moved_[PlaceOf({u, v, w})] = true;
            }
          }
        }
      }
    }
  }
}

size_t VolumeLattice::MostBytes(const LatticeStructure& s) {
  size_t spans = 1;
  for (size_t a = 0; a < 3; ++a) spans *= static_cast<size_t>(s.size[a] - s.degree[a]);
  return sizeof(VolumeLattice) + spans * (sizeof(double) + 1);
}

size_t VolumeLattice::PlaceOf(const std::array<int, 3>& span) const {
  const auto count = [&](size_t a) {
    return static_cast<size_t>(structure_.size[a] - structure_.degree[a]);
  };
  const auto at = [&](size_t a) { return static_cast<size_t>(span[a] - structure_.degree[a]); };
  return at(0) + count(0) * (at(1) + count(1) * at(2));
}

WorldCell VolumeLattice::CellBetween(Vec3d lower, Vec3d upper) const {
  WorldCell cell{.centre = map_.ToWorld(0.5 * (lower + upper)),
                 .size = Moduli(structure_.frame.origin)};
  for (int a = 0; a < 3; ++a) {
    cell.size += Moduli(structure_.frame.edges[static_cast<size_t>(a)]);
    const double share =
        0.5 * (upper[a] - lower[a]) / (structure_.domain_end(a) - structure_.domain_begin(a));
    cell.half[static_cast<size_t>(a)] = share * structure_.frame.edges[static_cast<size_t>(a)];
  }
  return cell;
}

VolumeLattice::View VolumeLattice::Look(const WorldCell& cell) const {
  View view{.centre = map_.ToParameter(cell.centre), .meets = true};
  for (size_t k = 0; k < 3; ++k) view.half[k] = map_.DirectionToParameter(cell.half[k]);
  const Vec3d far = cell.size + Moduli(structure_.frame.origin);
  for (size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<int>(a);
    const double begin = structure_.domain_begin(axis), end = structure_.domain_end(axis);
    const double rounding = 0x1p-47 * (1 + frame_.condition) * (1 + Dot(frame_.sizes[a], far));
    view.room[axis] = (rounding + 2 * kPlaneSnap) * (end - begin);
    const double reach =
        std::abs(view.half[0][axis]) + std::abs(view.half[1][axis]) + std::abs(view.half[2][axis]);
    view.lower[axis] = view.centre[axis] - reach - view.room[axis];
    view.upper[axis] = view.centre[axis] + reach + view.room[axis];
    const double inside = std::max(reach - view.room[axis], 0.5 * reach);
    view.inner_lower[axis] = view.centre[axis] - inside;
    view.inner_upper[axis] = view.centre[axis] + inside;
    view.leaves = view.leaves || view.inner_lower[axis] < begin || view.inner_upper[axis] > end;
    const std::vector<double>& knots = structure_.knots[a];
    int first = structure_.degree[a], last = structure_.size[a] - 1;
    while (first <= last &&
           (IsEmpty(a, first) || knots[static_cast<size_t>(first) + 1] < view.inner_lower[axis])) {
      ++first;
    }
    while (last >= first &&
           (IsEmpty(a, last) || knots[static_cast<size_t>(last)] > view.inner_upper[axis])) {
      --last;
    }
    view.first[a] = first;
    view.last[a] = last;
    view.meets = view.meets && first <= last;
  }
  return view;
}

template <typename Visit>
void VolumeLattice::ForEachSpan(const View& view, Visit visit) const {
  if (!view.meets) return;
  for (int w = view.first[2]; w <= view.last[2]; ++w) {
    if (IsEmpty(2, w)) continue;
    for (int v = view.first[1]; v <= view.last[1]; ++v) {
      if (IsEmpty(1, v)) continue;
      for (int u = view.first[0]; u <= view.last[0]; ++u) {
        if (!IsEmpty(0, u) && !visit(std::array<int, 3>{u, v, w})) return;
      }
    }
  }
}

bool VolumeLattice::Moves(const View& view) const {
  bool moves = false;
  ForEachSpan(view, [&](const std::array<int, 3>& span) {
    moves = Moves(span);
    return !moves;
  });
  return moves;
}

double VolumeLattice::Rise(const View& view) {
  double most = 0;
  ForEachSpan(view, [&](const std::array<int, 3>& span) {
    double& rise = rises_[PlaceOf(span)];
    if (rise == kUnknownRise) {
      rise = SlopesOfBox(structure_, points_, span).RiseOver(structure_.frame, frame_);
    }
    if (!(rise <= most)) most = rise;
    return !std::isnan(most);
  });
  return most;
}

size_t VolumeLattice::PieceCount(const View& view) const {
  size_t count = 0;
  ForEachSpan(view, [&](const std::array<int, 3>&) {
    ++count;
    return true;
  });
  return view.leaves ? count + 6 : count;
}

JacobianForm VolumeLattice::FormBetween(const WorldCell& cell, const View& view,
                                        const std::array<int, 3>& span, Vec3d lower,
                                        Vec3d upper) const {
  const BoxPart whole = WholeBox(structure_, span);
  const BoxSlopes slopes(structure_, points_, {span, lower, upper});
  constexpr double kMuchWider = 2;
  // By axis of the lattice: its box, and y over the part between `lower` and `upper`.
  struct Axis {
    double width = 0, room = 0, offset = 0;
    Vec3d slope;  // of y by t
    bool is_linear = false;
  };
  std::array<Axis, 3> axes;
  Vec3d shares;  // of the remainder, by axis of the cell
  for (size_t b = 0; b < 3; ++b) {
    const auto axis = static_cast<int>(b);
    const double half = 0.5 * (upper[axis] - lower[axis]);
    axes[b].width = whole.upper[axis] - whole.lower[axis];
    axes[b].offset = (view.centre[axis] - 0.5 * (lower[axis] + upper[axis])) / half;
    axes[b].room = view.room[axis] / half;
    double reach = 0;
    for (int k = 0; k < 3; ++k) {
      axes[b].slope[k] = view.half[static_cast<size_t>(k)][axis] / half;
      reach += std::abs(axes[b].slope[k]);
    }
    axes[b].is_linear = reach <= kMuchWider;
    for (int k = 0; k < 3; ++k) {
      const double across = view.half[static_cast<size_t>(k)][axis] / axes[b].width;
      shares[k] += across * across;
    }
  }
  shares = shares / (shares.x + shares.y + shares.z);
  JacobianForm form;
  for (size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<int>(a);
    BezierBox along;
    const double most = slopes.Along(a, along);
    const double share =
        axes[a].width / (structure_.domain_end(axis) - structure_.domain_begin(axis));
    const Vec3d edge = share * structure_.frame.edges[a];
    const LinearBound bound = BoundLinearly(along);
    Vec3d centre = bound.centre - edge, radius = bound.radius;
    std::array<Vec3d, 3> by_cell;
    for (size_t b = 0; b < 3; ++b) {
      const Vec3d slope = bound.slope[b];
      if (!axes[b].is_linear) {
        radius += Moduli(slope);
        continue;
      }
      centre += axes[b].offset * slope;
      radius += axes[b].room * Moduli(slope);
      for (int k = 0; k < 3; ++k) by_cell[static_cast<size_t>(k)] += axes[b].slope[k] * slope;
    }
    for (size_t l = 0; l < 3; ++l) {
      const double q = view.half[l][axis] / axes[a].width;
      const double rounding = (200 + 10 * frame_.condition) * 0x1p-53 *
                              Dot(frame_.sizes[a], Moduli(cell.half[l])) / share *
                              (most + LargestComponent(edge));
      form.centre[l] += q * centre;
      const Vec3d rest = std::abs(q) * radius + Vec3d{rounding, rounding, rounding};
      for (size_t k = 0; k < 3; ++k) {
        form.slope[l][k] += q * by_cell[k];
        form.bend[l][k] += shares[static_cast<int>(k)] * rest;
      }
    }
  }
  return form;
}

void VolumeLattice::AddPieces(const WorldCell& cell, const View& view,
                              std::vector<VolumePiece>& pieces) const {
  if (view.leaves || !view.meets) AddBeyond(view, pieces);
  ForEachSpan(view, [&](const std::array<int, 3>& span) {
    const BoxPart box = WholeBox(structure_, span);
    VolumePiece piece{.form = FormBetween(cell, view, span, Max(view.lower, box.lower),
                                          Min(view.upper, box.upper))};
    for (int a = 0; a < 3; ++a) {
      const Vec3d across{view.half[0][a], view.half[1][a], view.half[2][a]};
      if (view.upper[a] > box.upper[a]) {
        piece.planes[piece.plane_count++] = {across, box.upper[a] - view.centre[a] + view.room[a]};
      }
      if (view.lower[a] < box.lower[a]) {
        piece.planes[piece.plane_count++] = {-across, view.centre[a] - box.lower[a] + view.room[a]};
      }
    }
    pieces.push_back(piece);
    return true;
  });
}

void VolumeLattice::AddBeyond(const View& view, std::vector<VolumePiece>& pieces) const {
  for (int a = 0; a < 3; ++a) {
    const Vec3d across{view.half[0][a], view.half[1][a], view.half[2][a]};
    VolumePiece beyond{.plane_count = 1};
    if (view.inner_upper[a] > structure_.domain_end(a)) {
      beyond.planes[0] = {-across, view.centre[a] - structure_.domain_end(a) + view.room[a]};
      pieces.push_back(beyond);
    }
    if (view.inner_lower[a] < structure_.domain_begin(a)) {
      beyond.planes[0] = {across, structure_.domain_begin(a) - view.centre[a] + view.room[a]};
      pieces.push_back(beyond);
    }
  }
}

double VolumeLattice::Crossed(const View& view, size_t k) const {
  double most = 0;
  if (!view.meets) return most;
  for (size_t a = 0; a < 3; ++a) {
    int spans = 0;
    for (int span = view.first[a]; span <= view.last[a]; ++span) spans += IsEmpty(a, span) ? 0 : 1;
    const double width = structure_.knots[a][static_cast<size_t>(view.last[a]) + 1] -
                         structure_.knots[a][static_cast<size_t>(view.first[a])];
    most = std::max(most, std::abs(view.half[k][static_cast<int>(a)]) * spans / width);
  }
  return most;
}

}  // namespace latticed
