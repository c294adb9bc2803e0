// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A triangle of a mesh with weights, by its corners: points, bounds and derivatives of P = x + w G from those of the offset
// G = F(x) - x. s and t are the barycentrics of the second and the third corner.
//
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_WEIGHTS_WEIGHTED_TRIANGLE_H_
#define LATTICED_CORE_FFD_WEIGHTS_WEIGHTED_TRIANGLE_H_

#include <array>

#include "core/base/bounds.h"
#include "core/base/vec.h"

namespace latticed {

struct WeightedTriangle {
  std::array<Vec3d, 3> rest;
  std::array<double, 3> weight{};

  // Turns G and its derivatives by s and t at a point into those of P.
  void Combine(double s, double t, Vec3d& position, std::array<Vec3d, 2>& slope) const;
  // Bounds of P on the triangle, from bounds of G there.
  [[nodiscard]] Bounds Hull(const Bounds& offset) const;
  // Bounds of the derivative of P by s (e = 0) or t (e = 1): it differs from `slope` by at most `spread`. Before the call both
  // are those of G.
  void BoundSlope(size_t e, const Bounds& offset, Vec3d& slope, Vec3d& spread) const;
};

// Bounds of P where x lies in `rest`, G in `offset`, and w is from `least` to `most`.
[[nodiscard]] Bounds WeightedHull(const Bounds& rest, const Bounds& offset, double least,
                                  double most);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_WEIGHTS_WEIGHTED_TRIANGLE_H_
