// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What becomes of points outside the frame of a lattice.
//
//   fixed    they stay. The surface tears at a face of the frame whose control points move
//   falloff  the move of the face goes on, and ends at a distance `width` from the face; further out, points stay
//   linear   the move goes on as it leaves the face, along straight lines, to a distance `width`
//
// Widths are per side, in the order begin and end of u, of v, of w, and in lengths of the frame's edge of the axis. A side
// of width 0 is fixed. outside_map.h says how a lattice is continued.
//
// Threads  plain data
#ifndef LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_H_
#define LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_H_

#include <array>
#include <cstddef>

namespace latticed {

enum class OutsideMode { kFixed, kFalloff, kLinear };

struct Outside {
  OutsideMode mode = OutsideMode::kFixed;
  // Falloff: whether the first derivatives go on through the face (C1), or only the positions (C0). An axis of degree 1 has
  // kinks at its knots anyway, and is C0.
  bool smooth = true;
  std::array<double, 6> widths{};
  // Falloff: how far from the face the one knot between face and end is. An insertion of knots leaves it where it is, so
  // that the shape stays.
  std::array<double, 6> steps{};

  friend bool operator==(const Outside&, const Outside&) = default;
};

// The side of an axis in widths and steps.
[[nodiscard]] constexpr size_t SideOf(size_t axis, bool at_end) {
  return 2 * axis + (at_end ? 1 : 0);
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_H_
