// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares a view with the definition in double (core/ffd/direct_ffd.h).
//
//   D  = max(diagonal of the deformed points, diagonal of control points that influence a patch)
//   position error = largest |p - definition| / D
//   normal error   = largest angle / kappa where kappa <= kMostKappa, radians
//
// and with the tolerances of its pipeline (tests/support/tolerances.h).
#ifndef LATTICED_TESTS_BENCH_VERIFY_H_
#define LATTICED_TESTS_BENCH_VERIFY_H_

#include <cstddef>
#include <span>

#include "absl/status/status.h"
#include "core/backend.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

struct Precision {
  double position = 0;           // of D
  double normal = 0;             // radians per kappa
  double normal_of_allowed = 0;  // the largest angle as a part of the pipeline's tolerance there
  double scale = 0;              // D, world units
};

// `view` holds control_points[0]; every `stride`-th chunk is compared. For quantised views half a
// step of rounding (positions) and half a cell (normals) are taken off before the comparison.
[[nodiscard]] Precision Measure(const Scenario& scenario, Pipeline pipeline, DeformView& view,
                                size_t stride);

// kInternal naming what is wrong by how much, where a tolerance of the pipeline is missed.
[[nodiscard]] absl::Status Verify(const Scenario& scenario, Pipeline pipeline, DeformView& view);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_VERIFY_H_
