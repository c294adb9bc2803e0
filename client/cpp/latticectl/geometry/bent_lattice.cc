// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/bent_lattice.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace latticed::client {
namespace {

int LongestAxis(const std::array<double, 3>& lengths) {
  return static_cast<int>(std::ranges::max_element(lengths) - lengths.begin());
}

}  // namespace

void BendLattice(double twist, double bend, Lattice& lattice) {
  if (twist == 0 && bend == 0) return;  // keeps every bit
  const LatticeFrame& frame = lattice.structure.frame;
  const auto& [u, v, w] = frame.edges;
  const std::array<double, 3> lengths{Norm(u), Norm(v), Norm(w)};
  const int a = LongestAxis(lengths), b = (a + 1) % 3, c = (a + 2) % 3;
  const double length = lengths[static_cast<size_t>(a)];
  const Vec3d middle = frame.origin + 0.5 * (u + v + w);
  for (Vec3d& point : lattice.control_points) {
    const Vec3d from = point - middle;
    const double t = from[a] / length;
    const double cosine = std::cos(twist * t), sine = std::sin(twist * t);
    double x = from[a], z = sine * from[b] + cosine * from[c];
    const double y = cosine * from[b] - sine * from[c];
    if (bend != 0) {
      const double radius = length / bend, half = std::sin(0.5 * bend * t);
      x = (radius - z) * std::sin(bend * t);
      z = 2 * radius * half * half + z * std::cos(bend * t);  // exact also where the radius is huge
    }
    point[a] = middle[a] + x;
    point[b] = middle[b] + y;
    point[c] = middle[c] + z;
  }
}

}  // namespace latticed::client
