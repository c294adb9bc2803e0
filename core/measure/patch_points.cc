// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/patch_points.h"

#include <algorithm>

namespace latticed {

using points::BlockArray;
using points::BlockVec;

void PatchPoints::Add(const RestTriangle& triangle, std::span<const TriangleRulePoint> rule) {
  const size_t first = count_;
  count_ += rule.size();
  const auto set = [&](BlockArray& values, double corner, double s, double t) {
    for (size_t i = 0; i < rule.size(); ++i) {
      values[first + i] = corner + rule[i].barycentrics[1] * s + rule[i].barycentrics[2] * t;
    }
  };
  const auto fill = [&](BlockArray& values, double value) {
    std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(first), rule.size(), value);
  };
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<size_t>(c);
    set(rest_[0][k], triangle.corner[c], triangle.s[c], triangle.t[c]);
    fill(rest_[1][k], triangle.s[c]);
    fill(rest_[2][k], triangle.t[c]);
  }
  set(weight_[0], triangle.weight, triangle.weight_s, triangle.weight_t);
  fill(weight_[1], triangle.weight_s);
  fill(weight_[2], triangle.weight_t);
  for (size_t i = 0; i < rule.size(); ++i) h_[first + i] = 0.5 * rule[i].weight;
}

void PatchPoints::Evaluate() {
  for (BlockVec& move : moves_) ClearFrom(0, move);
  for (size_t g = 0; g < lattices_.size(); ++g) {
    const RunLattice& lattice = lattices_[g];
    points::MapBlock(lattice.map, {rest_[0][0].data(), rest_[0][1].data(), rest_[0][2].data()},
                     count_, local_[g]);
    points::EvaluateBlock(lattice.boxes->structure().degree, lattice.polynomial, local_[g], count_,
                          values_, &slopes_);
    patch_points::AddMoves(lattice.map, rest_, values_, slopes_, count_, moves_);
  }
  patch_points::Weigh(rest_, weight_, moves_, count_, at_);
}

void PatchPoints::ClearFrom(size_t count, BlockVec& forces) const {
  for (BlockArray& component : forces) {
    std::fill(component.begin() + static_cast<std::ptrdiff_t>(count),
              component.begin() + static_cast<std::ptrdiff_t>(points::PaddedCount(count_)), 0);
  }
}

void PatchPoints::AddVolume(bool with_moment, double& across, Vec3d& moment) {
  patch_points::VolumeForces(at_, weight_[0], h_, count_, forces_[0], scalar_);
  ClearFrom(count_, forces_[0]);
  for (size_t i = 0; i < count_; ++i) across += scalar_[i];
  if (!with_moment) return;
  for (size_t i = 0; i < count_; ++i) moment += scalar_[i] * position(i);
}

void PatchPoints::SumVolumeForces(std::span<BoxNumbers> sums, bool with_moment) {
  const size_t fields = with_moment ? 4 : 1;
  for (size_t f = 0; f < fields; ++f) {
    BlockVec& force = forces_[std::min<size_t>(f, 1)];
    if (f > 0) {
      const BlockArray& position = at_[0][f - 1];
      for (size_t c = 0; c < 3; ++c) {
        for (size_t i = 0; i < count_; ++i) force[c][i] = position[i] * forces_[0][c][i];
      }
      ClearFrom(count_, force);
    }
    for (size_t g = 0; g < lattices_.size(); ++g) {
      points::SumBlock(lattices_[g].boxes->structure().degree, local_[g], force, count_,
                       sums[g * fields + f]);
    }
  }
}

double PatchPoints::AreaOf(size_t begin, size_t end) const {
  double sum = 0;
  for (size_t i = begin; i < end; ++i) sum += h_[i] * scalar_[i];
  return sum;
}

void PatchPoints::LeaveOut(size_t begin, size_t end) {
  for (size_t i = begin; i < end; ++i) h_[i] = 0;
}

void PatchPoints::SumAreaForces(size_t count, bool is_weighted, std::span<BoxNumbers> sums) {
  patch_points::AreaForces(at_, weight_, h_, count, forces_);
  for (BlockVec& force : forces_) ClearFrom(count, force);
  for (size_t g = 0; g < lattices_.size(); ++g) {
    const auto& degree = lattices_[g].boxes->structure().degree;
    if (is_weighted) points::SumBlock(degree, local_[g], forces_[0], count, sums[g]);
    patch_points::SlopeForces(lattices_[g].map, rest_, forces_, count, slopes_);
    points::SumSlopeBlock(degree, local_[g], slopes_, count, sums[g]);
  }
}

}  // namespace latticed
