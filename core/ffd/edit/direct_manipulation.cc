// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/edit/direct_manipulation.h"

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <utility>

#include "core/base/limits.h"
#include "core/ffd/bspline_basis.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/minimum_norm.h"
#include "core/ffd/outside/outside_map.h"

namespace latticed {
namespace {

// Basis values by control point. The u index runs fastest, so columns ascend.
SparseRow BasisRow(const LatticeStructure& s, Vec3d world) {
  SparseRow row;
  const auto place = FindVolumePlace(s, world);
  if (!place.has_value()) return row;
  std::array<std::array<double, limits::kMaxDegree + 1>, 3> value{};
  std::array<int, 3> first{};
  for (size_t a = 0; a < 3; ++a) {
    EvaluateBasis(s.knots[a].data(), s.degree[a], place->span[a],
                  place->parameter[static_cast<int>(a)], value[a].data());
    first[a] = place->span[a] - s.degree[a];
  }
  for (int k = 0; k <= s.degree[2]; ++k) {
    for (int j = 0; j <= s.degree[1]; ++j) {
      for (int i = 0; i <= s.degree[0]; ++i) {
        const double v = value[0][static_cast<size_t>(i)] * value[1][static_cast<size_t>(j)] *
                         value[2][static_cast<size_t>(k)];
        if (v == 0) continue;
        row.columns.push_back(
            static_cast<uint32_t>(s.Index(first[0] + i, first[1] + j, first[2] + k)));
        row.values.push_back(v);
      }
    }
  }
  return row;
}

// The entries that are not zero, by column.
SparseRow RowOf(const std::map<uint32_t, double>& entries) {
  SparseRow row;
  for (const auto& [column, value] : entries) {
    if (value == 0) continue;
    row.columns.push_back(column);
    row.values.push_back(value);
  }
  return row;
}

// The same for a continued lattice: a row of its control points, by those of the given one.
SparseRow GivenRow(const OutsideMap& outside, const SparseRow& row) {
  std::map<uint32_t, double> given;
  for (size_t n = 0; n < row.columns.size(); ++n) {
    outside.ForSources(row.columns[n], [&](size_t source, double weight) {
      given[static_cast<uint32_t>(source)] += weight * row.values[n];
    });
  }
  return RowOf(given);
}

void Scale(double weight, SparseRow& row) {
  if (weight == 0) row = {};
  for (double& value : row.values) value *= weight;
}

// Keeps the free control points of a row.
void DropHeld(const PointFreedom& freedom, SparseRow& row) {
  size_t kept = 0;
  for (size_t n = 0; n < row.columns.size(); ++n) {
    if (freedom.is_held(row.columns[n])) continue;
    row.columns[kept] = row.columns[n];
    row.values[kept++] = row.values[n];
  }
  row.columns.resize(kept);
  row.values.resize(kept);
}

// The row with one column a pair of images, the lower one's. `sign` is -1 for moves across the mirror's plane.
SparseRow PairedRow(const PointFreedom& freedom, const SparseRow& row, double sign) {
  std::map<uint32_t, double> pairs;
  for (size_t n = 0; n < row.columns.size(); ++n) {
    const uint32_t index = row.columns[n];
    const auto image = static_cast<uint32_t>(freedom.ImageOf(index));
    if (image == index) {
      if (sign > 0) pairs[index] += row.values[n];
      continue;
    }
    pairs[std::min(index, image)] +=
        (index < image ? 1 : sign) * row.values[n] / std::numbers::sqrt2;
  }
  return RowOf(pairs);
}

// The columns of rows, ascending. Renumbers them in the rows: others take no part.
std::vector<uint32_t> NumberColumns(std::vector<SparseRow>& rows) {
  std::vector<uint32_t> columns;
  for (const SparseRow& row : rows) {
    columns.insert(columns.end(), row.columns.begin(), row.columns.end());
  }
  std::ranges::sort(columns);
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  for (SparseRow& row : rows) {
    for (uint32_t& column : row.columns) {
      column = static_cast<uint32_t>(std::ranges::lower_bound(columns, column) - columns.begin());
    }
  }
  return columns;
}

// Adds the part of the solution across the mirror's plane (sign -1) or along it (1) to the moves by control point.
void AddMirrored(const PointFreedom& freedom, const std::vector<SparseRow>& full,
                 std::span<const Vec3d> wanted, double sign, std::map<uint32_t, Vec3d>& moves) {
  std::vector<SparseRow> rows;
  rows.reserve(full.size());
  for (const SparseRow& row : full) rows.push_back(PairedRow(freedom, row, sign));
  std::vector<Vec3d> part;
  part.reserve(wanted.size());
  for (const Vec3d w : wanted) {
    part.push_back(sign < 0 ? freedom.Along(w) : w - freedom.Along(w));
  }
  const std::vector<uint32_t> columns = NumberColumns(rows);
  const std::vector<Vec3d> solution = MinimumNorm(std::move(rows), columns.size()).Solve(part);
  for (size_t n = 0; n < columns.size(); ++n) {
    const auto image = static_cast<uint32_t>(freedom.ImageOf(columns[n]));
    if (image == columns[n]) {
      moves[image] += solution[n];
      continue;
    }
    moves[columns[n]] += solution[n] / std::numbers::sqrt2;
    moves[image] += sign * solution[n] / std::numbers::sqrt2;
  }
}

ControlPointMoves DragMirrored(const PointFreedom& freedom, const std::vector<SparseRow>& rows,
                               std::span<const Vec3d> wanted) {
  std::map<uint32_t, Vec3d> by_point;
  AddMirrored(freedom, rows, wanted, 1, by_point);
  AddMirrored(freedom, rows, wanted, -1, by_point);
  ControlPointMoves moves;
  for (const auto& [index, offset] : by_point) {
    moves.indices.push_back(index);
    moves.offsets.push_back(offset);
  }
  for (size_t i = 0; i < rows.size(); ++i) {
    Vec3d left = wanted[i];
    for (size_t n = 0; n < rows[i].columns.size(); ++n) {
      const auto found = by_point.find(rows[i].columns[n]);
      if (found != by_point.end()) left -= rows[i].values[n] * found->second;
    }
    moves.residual = std::max(moves.residual, Norm(left));
  }
  return moves;
}

}  // namespace

ControlPointMoves DragToTargets(const Lattice& lattice, std::span<const Vec3d> points,
                                std::span<const Vec3d> targets, const PointFreedom* freedom,
                                std::span<const double> weights, double strength) {
  const OutsideMap outside(lattice.structure, strength);
  const LatticeStructure& continued = outside.continued();
  const std::vector<Vec3d> control_points = outside.Continue(lattice.control_points);
  std::vector<SparseRow> rows;
  std::vector<Vec3d> wanted;
  for (size_t i = 0; i < points.size(); ++i) {
    rows.push_back(BasisRow(continued, points[i]));
    if (!outside.is_identity()) rows.back() = GivenRow(outside, rows.back());
    if (freedom != nullptr) DropHeld(*freedom, rows.back());
    Vec3d position = EvaluateWorld(continued, control_points, points[i]).position;
    if (!weights.empty()) {
      Scale(weights[i], rows.back());
      position = points[i] + weights[i] * (position - points[i]);
    }
    wanted.push_back(targets[i] - position);
  }
  if (freedom != nullptr && freedom->is_mirrored()) return DragMirrored(*freedom, rows, wanted);
  ControlPointMoves moves{.indices = NumberColumns(rows)};
  const MinimumNorm system(std::move(rows), moves.indices.size());
  moves.offsets = system.Solve(wanted);
  for (const Vec3d left : system.Residual(wanted, moves.offsets)) {
    moves.residual = std::max(moves.residual, Norm(left));
  }
  return moves;
}

}  // namespace latticed
