// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An axis-aligned box of points; empty until the first Extend.
#ifndef LATTICED_CORE_BASE_BOUNDS_H_
#define LATTICED_CORE_BASE_BOUNDS_H_

#include <limits>

#include "core/base/vec.h"

namespace latticed {

struct Bounds {
  Vec3d min{kInfinity, kInfinity, kInfinity};
  Vec3d max{-kInfinity, -kInfinity, -kInfinity};

  void Extend(Vec3d p) {
    min = Min(min, p);
    max = Max(max, p);
  }
  void Extend(const Bounds& other) {
    min = Min(min, other.min);
    max = Max(max, other.max);
  }
  bool empty() const { return min.x > max.x; }
  Vec3d center() const { return 0.5 * min + 0.5 * max; }
  Vec3d extent() const { return max - min; }
  double diagonal() const { return empty() ? 0.0 : Norm(extent()); }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_BOUNDS_H_
