// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares a view with the definition in double (core/ffd/direct_ffd.h).  DESIGN §2 "Precision"
//
//   D  = max(diagonal of the deformed points, diagonal of control points that influence a patch)
//   position error = largest |p - definition| / D
//   normal error   = largest angle / kappa where kappa <= 100, radians
#ifndef LATTICED_TESTS_BENCH_VERIFY_H_
#define LATTICED_TESTS_BENCH_VERIFY_H_

#include <cstddef>
#include <span>

#include "absl/status/status.h"
#include "core/backend.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

// DESIGN §2, relative to D and to kappa.
inline constexpr double kFusedPositionError = 3e-7;
inline constexpr double kGemmPositionError = 1e-6;
inline constexpr double kFusedNormalError = 2e-5;

struct Precision {
  double position = 0;  // of D
  double normal = 0;    // radians per kappa
  double scale = 0;     // D, world units
};

// `view` holds control_points[0]; every `stride`-th chunk is compared. For quantised views half a
// step of rounding (positions) and half a cell (normals) are taken off before the comparison.
[[nodiscard]] Precision Measure(const Scenario& scenario, DeformView& view, size_t stride);

// kInternal naming what is wrong by how much, where the guarantee of the pipeline is missed.
[[nodiscard]] absl::Status Verify(const Scenario& scenario, Pipeline pipeline, DeformView& view);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_VERIFY_H_
