// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which continuations outside the frame are legal, and what the server fills in.
//
// Errors   kInvalidArgument naming a field that begins with "lattice"
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_RULES_H_
#define LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_RULES_H_

#include <span>

#include "absl/status/status.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"

namespace latticed {

// Widths are 0, or between these.
inline constexpr double kLeastOutsideWidth = 1e-3;
inline constexpr double kMostOutsideWidth = 1e3;

// Checks structure.outside, filled in; the rest of the structure must be valid. A side with a width needs clamped knots. The
// continued lattice has at most limits::kMaxControlPoints control points.
[[nodiscard]] absl::Status ValidateOutside(const LatticeStructure& structure);

// Fills in what is not set, which is 0:
//   linear   the widths, if all are 0: as far as the points `mesh` of the rest world reach, and 1/16 more
//   falloff  the steps of sides with a width: W/2, and no more than a quarter of the knot span at the face, so that a smooth
//            continuation does not overshoot. The structure must be valid but for them
// A fixed one, and one whose widths stay 0, becomes Outside{}.
[[nodiscard]] Outside ResolvedOutside(const LatticeStructure& structure,
                                      std::span<const Vec3d> mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_RULES_H_
