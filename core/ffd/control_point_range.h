// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The limit of control points' coordinates. A lattice that is fitted with the largest padding to a mesh at
// limits::kMaxCoordinate stays below it, and the squares of coordinates fit in float32.
#ifndef LATTICED_CORE_FFD_CONTROL_POINT_RANGE_H_
#define LATTICED_CORE_FFD_CONTROL_POINT_RANGE_H_

#include <cmath>
#include <string_view>

#include "absl/status/status.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/base/vec.h"

namespace latticed {

inline constexpr double kMaxControlCoordinate = 1e3 * limits::kMaxCoordinate;

// kInvalidArgument naming `field`, reason NOT_FINITE or OUT_OF_RANGE.
[[nodiscard]] inline absl::Status CheckControlCoordinate(double x, std::string_view field) {
  if (!std::isfinite(x)) return error::NotFinite(field);
  return error::CheckRange(field, x, -kMaxControlCoordinate, kMaxControlCoordinate);
}

[[nodiscard]] inline absl::Status CheckControlPoint(Vec3d p, std::string_view field) {
  for (int c = 0; c < 3; ++c) {
    LATTICED_RETURN_IF_ERROR(CheckControlCoordinate(p[c], field));
  }
  return absl::OkStatus();
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_CONTROL_POINT_RANGE_H_
