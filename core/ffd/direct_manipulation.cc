// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/direct_manipulation.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/limits.h"
#include "core/ffd/bspline_basis.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/minimum_norm.h"

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

}  // namespace

ControlPointMoves DragToTargets(const Lattice& lattice, std::span<const Vec3d> points,
                                std::span<const Vec3d> targets) {
  ControlPointMoves moves;
  std::vector<SparseRow> rows;
  std::vector<Vec3d> wanted;
  for (size_t i = 0; i < points.size(); ++i) {
    rows.push_back(BasisRow(lattice.structure, points[i]));
    moves.indices.insert(moves.indices.end(), rows[i].columns.begin(), rows[i].columns.end());
    wanted.push_back(targets[i] -
                     EvaluateWorld(lattice.structure, lattice.control_points, points[i]).position);
  }
  std::ranges::sort(moves.indices);
  moves.indices.erase(std::unique(moves.indices.begin(), moves.indices.end()), moves.indices.end());
  for (SparseRow& row : rows) {  // renumbers columns: others take no part
    for (uint32_t& column : row.columns) {
      column = static_cast<uint32_t>(std::ranges::lower_bound(moves.indices, column) -
                                     moves.indices.begin());
    }
  }
  const MinimumNorm system(std::move(rows), moves.indices.size());
  moves.offsets = system.Solve(wanted);
  for (const Vec3d left : system.Residual(wanted, moves.offsets)) {
    moves.residual = std::max(moves.residual, Norm(left));
  }
  return moves;
}

}  // namespace latticed
