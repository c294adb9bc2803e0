// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/lattices/mixed_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace latticed::testing {

void MixedModel::Do(uint32_t number, NumberState next) {
  History& history = numbers_[number];
  history.done.push_back(std::exchange(history.now, std::move(next)));
  history.undone.clear();
}

void MixedModel::Undo(uint32_t number) {
  History& history = numbers_[number];
  history.undone.push_back(std::exchange(history.now, std::move(history.done.back())));
  history.done.pop_back();
}

void MixedModel::Redo(uint32_t number) {
  History& history = numbers_[number];
  history.done.push_back(std::exchange(history.now, std::move(history.undone.back())));
  history.undone.pop_back();
}

bool MixedModel::LeavesAny(uint32_t number, bool undo) const {
  const History& history = numbers_.at(number);
  if ((undo ? history.done : history.undone).back().present) return true;
  const std::vector<uint32_t> present = Present();
  return std::ranges::any_of(present, [&](uint32_t other) { return other != number; });
}

std::vector<uint32_t> MixedModel::Present() const {
  std::vector<uint32_t> present;
  for (const auto& [number, history] : numbers_) {
    if (history.now.present) present.push_back(number);
  }
  return present;
}

std::vector<LatticeDefinition> MixedModel::Definitions() const {
  std::vector<LatticeDefinition> definitions;
  for (const auto& [number, history] : numbers_) {
    const NumberState& now = history.now;
    if (!now.present) continue;
    definitions.emplace_back(now.lattice.structure, now.lattice.control_points, now.strength);
  }
  return definitions;
}

double MixedModel::WeightAt(size_t triangle, const std::array<double, 3>& b) const {
  if (!weights().has_value()) return 1;
  double weight = 0;
  for (size_t c = 0; c < 3; ++c) weight += b[c] * double{(*weights())[kCubeTriangles[triangle][c]]};
  return weight;
}

double MixedModel::WeightAt(Vec3d rest) const {
  size_t nearest = 0;
  std::array<double, 3> at{};
  double least = -1e9;
  for (size_t t = 0; t < kCubeTriangles.size(); ++t) {
    const auto& [a, b, c] = kCubeTriangles[t];
    const Vec3d p = kCubeVertices[a], e1 = kCubeVertices[b] - p, e2 = kCubeVertices[c] - p;
    const Vec3d normal = Cross(e1, e2);  // of length 1
    const std::array<double, 2> of{Dot(Cross(rest - p, e2), normal),
                                   Dot(Cross(e1, rest - p), normal)};
    // How far inside the triangle, less how far above it.
    const double inside = std::min({of[0], of[1], 1 - of[0] - of[1]});
    const double depth = std::min(inside, 0.0) - std::abs(Dot(rest - p, normal));
    if (depth <= least) continue;
    least = depth;
    nearest = t;
    at = {1 - of[0] - of[1], of[0], of[1]};
  }
  return WeightAt(nearest, at);
}

}  // namespace latticed::testing
