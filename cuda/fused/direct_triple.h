// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The order in which the direct kernel takes the points of a patch: by three, which go into each
// other when its corners are rotated.
#ifndef LATTICED_CUDA_FUSED_DIRECT_TRIPLE_H_
#define LATTICED_CUDA_FUSED_DIRECT_TRIPLE_H_

#include "core/base/host_device.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed::kernels {

// Barycentric coordinates by corners r, r + 1, r + 2, times segments.
struct DirectTriple {
  int segments;
  int steps[3];

  // The corners.
  LATTICED_HD constexpr explicit DirectTriple(int segments)
      : segments(segments), steps{segments, 0, 0} {}
  // All others, each once but the middle, thrice at a time, the rim's first; false when there are no more.
  LATTICED_HD constexpr bool Next() {
    do {
      ++steps[1];
      if (steps[1] + steps[2] >= segments) {
        steps[1] = 1;
        ++steps[2];
        if (steps[2] + 1 >= segments) return false;
      }
      steps[0] = segments - steps[1] - steps[2];
    } while (!IsFirst());
    return true;
  }
  // Then points are steps[1] along edges, from corner r on.
  LATTICED_HD constexpr bool IsOnRim() const { return steps[2] == 0; }
  // In the pattern, of the point that is turned by r corners.
  LATTICED_HD constexpr int Index(int r) const {
    return PointIndex(segments, steps[2 - r], steps[r == 2 ? 2 : 1 - r]);
  }

 private:
  // Whether this is the first of the three that name the same points, or the middle, which is its
  // own three. On the rim Next gives none twice.
  LATTICED_HD constexpr bool IsFirst() const {
    const int a = steps[0], b = steps[1], c = steps[2];
    return c == 0 || (a > b && a >= c) || (a == b && b == c);
  }
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_DIRECT_TRIPLE_H_
