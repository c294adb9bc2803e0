// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/turn_lattice.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace latticed::client {
namespace {

struct Direction {
  double cosine = 1, sine = 0;
};

// std::cos(pi / 2) is not 0, so quarter turns have a table.
Direction DirectionOf(double degrees) {
  const double quarters = degrees / 90;
  if (quarters != std::floor(quarters)) {
    const double angle = degrees * std::numbers::pi / 180;
    return {std::cos(angle), std::sin(angle)};
  }
  constexpr std::array<Direction, 4> kQuarters{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  return kQuarters[static_cast<size_t>(quarters - 4 * std::floor(quarters / 4))];
}

Vec3d TurnedAbout(int axis, double degrees, Vec3d p) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const auto [cosine, sine] = DirectionOf(degrees);
  Vec3d turned = p;
  turned[b] = cosine * p[b] - sine * p[c];
  turned[c] = sine * p[b] + cosine * p[c];
  return turned;
}

}  // namespace

void TurnLattice(Vec3d degrees, Lattice& lattice) {
  if (degrees == Vec3d{}) return;  // keeps every bit
  const auto turned = [degrees](Vec3d p) {
    for (int axis = 0; axis < 3; ++axis) p = TurnedAbout(axis, degrees[axis], p);
    return p;
  };
  const std::vector<Vec3d> before = IdentityControlPoints(lattice.structure);
  LatticeFrame& frame = lattice.structure.frame;
  const Vec3d middle = frame.origin + 0.5 * (frame.edges[0] + frame.edges[1] + frame.edges[2]);
  frame.origin = middle + turned(frame.origin - middle);
  for (Vec3d& edge : frame.edges) edge = turned(edge);
  // Faces where no control point has moved do not tear: "moved" is compared without tolerance.
  const std::vector<Vec3d> after = IdentityControlPoints(lattice.structure);
  for (size_t i = 0; i < after.size(); ++i) {
    lattice.control_points[i] = after[i] + turned(lattice.control_points[i] - before[i]);
  }
}

}  // namespace latticed::client
