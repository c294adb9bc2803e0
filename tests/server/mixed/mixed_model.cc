// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/mixed/mixed_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace latticed::testing {
namespace {

// i and size - 1 - i of the axis.
uint32_t ImageOf(const LatticeStructure& s, size_t axis, uint32_t point) {
  int stride = 1;
  for (size_t a = 0; a < axis; ++a) stride *= s.size[a];
  const int index = static_cast<int>(point), at = index / stride % s.size[axis];
  return static_cast<uint32_t>(index + (s.size[axis] - 1 - 2 * at) * stride);
}

// Seen in the plane through the frame's centre.
Vec3d Mirrored(const NumberState& state, Vec3d p) {
  const LatticeFrame& frame = state.lattice.structure.frame;
  const Vec3d centre = frame.origin + 0.5 * (frame.edges[0] + frame.edges[1] + frame.edges[2]);
  const Vec3d normal = MirrorNormal(state);
  return p - 2 * Dot(p - centre, normal) * normal;
}

// How far inside the triangle, less how far above it.
double DepthIn(size_t triangle, Vec3d rest, CubePlace& place) {
  const auto& [a, b, c] = kCubeTriangles[triangle];
  const Vec3d p = kCubeVertices[a], e1 = kCubeVertices[b] - p, e2 = kCubeVertices[c] - p;
  const Vec3d normal = Cross(e1, e2);  // of length 1
  const double at_b = Dot(Cross(rest - p, e2), normal), at_c = Dot(Cross(e1, rest - p), normal);
  place = {.triangle = triangle, .barycentrics = {1 - at_b - at_c, at_b, at_c}, .rest = rest};
  return std::min(std::ranges::min(place.barycentrics), 0.0) - std::abs(Dot(rest - p, normal));
}

}  // namespace

Vec3d MirrorNormal(const NumberState& state) {
  const Vec3d edge = state.lattice.structure.frame.edges[static_cast<size_t>(*state.mirror)];
  return edge / Norm(edge);
}

bool IsHeld(const NumberState& state, uint32_t point) {
  if (std::ranges::binary_search(state.held, point)) return true;
  if (!state.mirror.has_value()) return false;
  const auto axis = static_cast<size_t>(*state.mirror);
  return std::ranges::binary_search(state.held, ImageOf(state.lattice.structure, axis, point));
}

void MoveAllowed(NumberState& state, const std::set<uint32_t>& points, Vec3d offset) {
  std::vector<Vec3d>& at = state.lattice.control_points;
  for (const uint32_t point : points) {
    if (!IsHeld(state, point)) at[point] += offset;
  }
  if (!state.mirror.has_value()) return;
  for (const uint32_t point : points) {
    const uint32_t image =
        ImageOf(state.lattice.structure, static_cast<size_t>(*state.mirror), point);
    if (IsHeld(state, point)) continue;
    if (points.contains(image)) at[point] = 0.5 * (at[point] + Mirrored(state, at[image]));
    at[image] = Mirrored(state, at[point]);
  }
}

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

double MixedModel::WeightAt(const CubePlace& place) const {
  if (!weights().has_value()) return 1;
  double weight = 0;
  for (size_t c = 0; c < 3; ++c) {
    weight += place.barycentrics[c] * double{(*weights())[kCubeTriangles[place.triangle][c]]};
  }
  return weight;
}

// grad(w) = (w_b - w_a) (e_2 x n) + (w_c - w_a) (n x e_1), with n of length 1.
Vec3d MixedModel::WeightGradient(size_t triangle) const {
  if (!weights().has_value()) return {};
  const auto& [a, b, c] = kCubeTriangles[triangle];
  const Vec3d e1 = kCubeVertices[b] - kCubeVertices[a], e2 = kCubeVertices[c] - kCubeVertices[a];
  const Vec3d normal = Cross(e1, e2);
  const double first = double{(*weights())[a]};
  return (double{(*weights())[b]} - first) * Cross(e2, normal) +
         (double{(*weights())[c]} - first) * Cross(normal, e1);
}

DeformedPoint MixedModel::SurfaceAt(std::span<const LatticeDefinition> lattices,
                                    const CubePlace& place, Vec3d within) const {
  const DeformedPoint sum = SumAt(lattices, place.rest, within);
  const Vec3d moved = sum.position - place.rest;
  const double weight = WeightAt(place);
  const Vec3d gradient = WeightGradient(place.triangle);
  DeformedPoint point{.position = place.rest + weight * moved};
  for (size_t a = 0; a < 3; ++a) {
    Vec3d& column = point.jacobian[a];
    column += weight * (sum.jacobian[a] - column) + gradient[static_cast<int>(a)] * moved;
  }
  return point;
}

CubePlace PlaceAt(Vec3d rest) {
  CubePlace nearest, place;
  double least = -1e9;
  for (size_t t = 0; t < kCubeTriangles.size(); ++t) {
    const double depth = DepthIn(t, rest, place);
    if (depth <= least) continue;
    least = depth;
    nearest = place;
  }
  return nearest;
}

std::vector<CubePlace> PlacesAt(Vec3d rest) {
  std::vector<CubePlace> places;
  CubePlace place;
  for (size_t t = 0; t < kCubeTriangles.size(); ++t) {
    if (DepthIn(t, rest, place) > -1e-9) places.push_back(place);
  }
  return places;
}

}  // namespace latticed::testing
