// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/box/box_contraction.h"

namespace latticed {
namespace {

std::array<size_t, 3> CountsOf(const std::array<int, 3>& degree) {
  return {static_cast<size_t>(degree[0]) + 1, static_cast<size_t>(degree[1]) + 1,
          static_cast<size_t>(degree[2]) + 1};
}

}  // namespace

BoxContraction::BoxContraction(const LatticeStructure& structure, const std::array<int, 3>& span,
                               const std::array<const SpanBasis*, 3>& basis)
    : count_(CountsOf(structure.degree)),
      basis_(basis),
      first_(static_cast<size_t>(structure.Index(span[0] - structure.degree[0],
                                                 span[1] - structure.degree[1],
                                                 span[2] - structure.degree[2]))),
      row_(static_cast<size_t>(structure.size[0])),
      layer_(row_ * static_cast<size_t>(structure.size[1])) {}

BoxNumbers BoxContraction::Contract(std::span<const Vec3d> points, Vec3d origin) const {
  const SpanBasis &u = *basis_[0], &v = *basis_[1], &w = *basis_[2];
  BoxNumbers result;
  for (size_t i = 0; i < count_[0]; ++i) {
    double plane[kPowers][kPowers][3] = {};  // [q][r] of control points i
    for (size_t j = 0; j < count_[1]; ++j) {
      double line[kPowers][3] = {};  // [r] of control points i, j
      for (size_t k = 0; k < count_[2]; ++k) {
        const Vec3d p = points[Number(i, j, k)] - origin;
        for (size_t r = 0; r < count_[2]; ++r) {
          for (int c = 0; c < 3; ++c) line[r][c] += w[k][r] * p[c];
        }
      }
      for (size_t q = 0; q < count_[1]; ++q) {
        for (size_t r = 0; r < count_[2]; ++r) {
          for (size_t c = 0; c < 3; ++c) plane[q][r][c] += v[j][q] * line[r][c];
        }
      }
    }
    for (size_t p = 0; p < count_[0]; ++p) {
      for (size_t q = 0; q < count_[1]; ++q) {
        for (size_t r = 0; r < count_[2]; ++r) {
          for (size_t c = 0; c < 3; ++c) result.at[p][q][r][c] += u[i][p] * plane[q][r][c];
        }
      }
    }
  }
  return result;
}

BoxVectors BoxContraction::Transpose(const BoxNumbers& sums) const {
  const SpanBasis &u = *basis_[0], &v = *basis_[1], &w = *basis_[2];
  BoxVectors result;
  for (size_t i = 0; i < count_[0]; ++i) {
    double plane[kPowers][kPowers][3] = {};  // [q][r] for control points i
    for (size_t p = 0; p < count_[0]; ++p) {
      for (size_t q = 0; q < count_[1]; ++q) {
        for (size_t r = 0; r < count_[2]; ++r) {
          for (size_t c = 0; c < 3; ++c) plane[q][r][c] += u[i][p] * sums.at[p][q][r][c];
        }
      }
    }
    for (size_t j = 0; j < count_[1]; ++j) {
      double line[kPowers][3] = {};  // [r] for control points i, j
      for (size_t q = 0; q < count_[1]; ++q) {
        for (size_t r = 0; r < count_[2]; ++r) {
          for (size_t c = 0; c < 3; ++c) line[r][c] += v[j][q] * plane[q][r][c];
        }
      }
      for (size_t k = 0; k < count_[2]; ++k) {
        Vec3d& sum = result.at[i][j][k];
        for (size_t r = 0; r < count_[2]; ++r) {
          for (int c = 0; c < 3; ++c) sum[c] += w[k][r] * line[r][c];
        }
      }
    }
  }
  return result;
}

}  // namespace latticed
