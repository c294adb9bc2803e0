// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The order in which the direct kernel takes the points of a patch: three at a time. Rotating the corners
// of the patch takes the three points of a triple to each other.
#ifndef LATTICED_CUDA_FUSED_DIRECT_TRIPLE_H_
#define LATTICED_CUDA_FUSED_DIRECT_TRIPLE_H_

#include "core/base/host_device.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed::kernels {

// steps: barycentric coordinates of point r with respect to corners r, r + 1, r + 2, times segments.
struct DirectTriple {
  int segments;
  int steps[3];

  // Begins with the three corners.
  LATTICED_HD constexpr explicit DirectTriple(int segments)
      : segments(segments), steps{segments, 0, 0} {}
  // Goes on to the next triple, those on the rim first; false when there are no more. Each point comes
  // once, except that the middle is all three points of its triple.
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
  // Point r is then steps[1] segments from corner r, on the edge that begins there.
  LATTICED_HD constexpr bool IsOnRim() const { return steps[2] == 0; }
  // The index of point r in the tessellation pattern.
  LATTICED_HD constexpr int Index(int r) const { return PointIndex(segments, Row(r), Column(r)); }
  LATTICED_HD constexpr int Row(int r) const { return steps[2 - r]; }
  LATTICED_HD constexpr int Column(int r) const { return steps[r == 2 ? 2 : 1 - r]; }

 private:
  // Three values of `steps` name the same three points; this says whether these are the first of them.
  // The middle has only one. On the rim Next makes none twice.
  LATTICED_HD constexpr bool IsFirst() const {
    const int a = steps[0], b = steps[1], c = steps[2];
    return c == 0 || (a > b && a >= c) || (a == b && b == c);
  }
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_DIRECT_TRIPLE_H_
