// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/block_weights.h"

namespace latticed::points {

BlockWeights::BlockWeights(const LocalMap& map, std::span<const PointWeight> weights)
    : weights_(weights) {
  // The edges are the columns of the inverse of the rows `scale`.
  const auto& rows = map.scale;
  const double determinant = Dot(rows[0], Cross(rows[1], rows[2]));
  for (size_t a = 0; a < 3; ++a) {
    edges_[a] = Cross(rows[(a + 1) % 3], rows[(a + 2) % 3]) / determinant;
  }
}

// The derivatives of the weight by l, m, n.
Vec3d BlockWeights::Rise(size_t i) const {
  const Vec3d gradient = weights_[i].gradient;
  return {Dot(gradient, edges_[0]), Dot(gradient, edges_[1]), Dot(gradient, edges_[2])};
}

void BlockWeights::WeighValues(const std::array<const double*, 3>& world, BlockVec& values,
                               BlockSlopes* slopes) const {
  for (size_t i = 0; i < weights_.size(); ++i) {
    const double w = weights_[i].weight;
    const Vec3d rise = Rise(i);
    for (size_t c = 0; c < 3; ++c) {
      const double offset = values[c][i] - world[c][i];
      values[c][i] = world[c][i] + w * offset;
      if (slopes == nullptr) continue;
      for (size_t a = 0; a < 3; ++a) {
        double& slope = (*slopes)[a][c][i];
        slope = w * slope + (1 - w) * edges_[a][static_cast<int>(c)] +
                rise[static_cast<int>(a)] * offset;
      }
    }
  }
}

void BlockWeights::WeighVelocities(BlockVec& values, BlockSlopes* slopes) const {
  for (size_t i = 0; i < weights_.size(); ++i) {
    const double w = weights_[i].weight;
    const Vec3d rise = Rise(i);
    for (size_t c = 0; c < 3; ++c) {
      const double velocity = values[c][i];
      values[c][i] = w * velocity;
      if (slopes == nullptr) continue;
      for (size_t a = 0; a < 3; ++a) {
        double& slope = (*slopes)[a][c][i];
        slope = w * slope + rise[static_cast<int>(a)] * velocity;
      }
    }
  }
}

void BlockWeights::WeighCotangents(BlockVec& values, BlockSlopes* slopes) const {
  for (size_t i = 0; i < weights_.size(); ++i) {
    const double w = weights_[i].weight;
    const Vec3d rise = Rise(i);
    for (size_t c = 0; c < 3; ++c) {
      values[c][i] *= w;
      if (slopes == nullptr) continue;
      for (size_t a = 0; a < 3; ++a) {
        double& slope = (*slopes)[a][c][i];
        values[c][i] += rise[static_cast<int>(a)] * slope;
        slope *= w;
      }
    }
  }
}

}  // namespace latticed::points
