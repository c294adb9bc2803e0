// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomial of a knot box on a triangle, by its corners in parameter space: points, bounds and derivatives. s and t are
// the barycentrics of the second and the third corner. Results are added, so that lattices add up.
//
// Threads  const functions may run at once
#ifndef LATTICED_CORE_FFD_PICK_VOLUME_TRIANGLE_H_
#define LATTICED_CORE_FFD_PICK_VOLUME_TRIANGLE_H_

#include <array>
#include <span>

#include "core/base/bounds.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"

namespace latticed {

struct VolumeTriangle {
  const LatticeStructure& structure;
  std::span<const Vec3d> control_points;
  const std::array<int, 3>& span;
  std::array<Vec3d, 3> corners;

  // Adds bounds of the polynomial on the triangle, and of its derivatives by s and t, which differ from `slope` by at most
  // `spread`.
  void Bound(Bounds& hull, std::array<Vec3d, 2>& slope, std::array<Vec3d, 2>& spread) const;
  // Adds the value and the derivatives at a point.
  void Add(double s, double t, Vec3d& position, std::array<Vec3d, 2>& slope) const;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PICK_VOLUME_TRIANGLE_H_
