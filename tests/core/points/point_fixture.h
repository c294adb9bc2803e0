// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices and points for tests of core/points.
#ifndef LATTICED_TESTS_CORE_POINTS_POINT_FIXTURE_H_
#define LATTICED_TESTS_CORE_POINTS_POINT_FIXTURE_H_

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/carried_normal.h"
#include "core/ffd/lattice.h"

namespace latticed {

// An oblique, left-handed frame, so that a mix-up of axes is noticed.
inline LatticeStructure ObliqueStructure(std::array<int, 3> degree, std::array<int, 3> more) {
  LatticeStructure s;
  s.degree = degree;
  for (size_t a = 0; a < 3; ++a) {
    s.size[a] = degree[a] + more[a];
    s.knots[a] = ClampedUniformKnots(s.degree[a], s.size[a]);
  }
  s.frame = {{1, 2, 3}, {Vec3d{2, 0.2, 0}, Vec3d{0.1, 0.3, 3}, Vec3d{0, 4, 0.5}}};
  return s;
}

class RandomVectors {
 public:
  explicit RandomVectors(uint32_t seed) : random_(seed) {}

  Vec3d Next(double amount = 1) {
    std::uniform_real_distribution<double> uniform(-amount, amount);
    const double x = uniform(random_), y = uniform(random_), z = uniform(random_);
    return {x, y, z};
  }
  std::vector<Vec3d> Some(size_t count, double amount = 1) {
    std::vector<Vec3d> result(count);
    for (Vec3d& v : result) v = Next(amount);
    return result;
  }
  std::vector<Vec3d> Units(size_t count) {
    std::vector<Vec3d> result(count);
    for (Vec3d& v : result) v = Unit(Next());
    return result;
  }
  // Control points moved from rest by up to `amount`.
  std::vector<Vec3d> Jittered(const LatticeStructure& s, double amount) {
    std::vector<Vec3d> points = IdentityControlPoints(s);
    for (Vec3d& p : points) p += Next(amount);
    return points;
  }
  // Points in the frame, one in eight of them outside.
  std::vector<Vec3d> Around(const LatticeStructure& s, size_t count) {
    std::vector<Vec3d> points(count);
    for (size_t i = 0; i < count; ++i) {
      Vec3d at = 0.5 * (Next() + Vec3d{1, 1, 1});
      if (i % 8 == 7) at.y += 1.5;
      points[i] = s.frame.origin + at.x * s.frame.edges[0] + at.y * s.frame.edges[1] +
                  at.z * s.frame.edges[2];
    }
    return points;
  }

 private:
  std::mt19937 random_;
};

// Sums of products of many numbers, with an error far below what the tests look for.
inline double LongDot(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  long double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    for (int c = 0; c < 3; ++c) sum += static_cast<long double>(a[i][c]) * b[i][c];
  }
  return static_cast<double>(sum);
}

}  // namespace latticed

#endif  // LATTICED_TESTS_CORE_POINTS_POINT_FIXTURE_H_
