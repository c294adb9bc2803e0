// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How far the vertices of a comparator are from the definition in double (core/ffd/direct_ffd.h),
// each at its own surface coordinates.
//
//   position error  largest |p - definition| / diagonal of the deformed points
//   normal error    largest angle / (kappa aspect), where kappa <= 100 and aspect <= 1,000. The
//                   comparators have no frame for slivers, so rounding grows with the aspect
//
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_COMPARATOR_PRECISION_H_
#define LATTICED_TESTS_BENCH_PAPER_COMPARATOR_PRECISION_H_

#include <algorithm>

#include "absl/status/status.h"
#include "core/base/bounds.h"
#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"
#include "tests/support/definition.h"

namespace latticed::bench {

struct ComparatorPrecision {
  static constexpr double kMostAspect = 1e3;

  double distance = 0;  // world units
  double normal = 0;
  Bounds deformed;             // of the points, by the definition
  size_t distinct_points = 0;  // shaders only: distinct coordinates of a patch

  double position() const { return distance / deformed.diagonal(); }

  void Add(const DirectFfd::SurfacePoint& expected, Vec3d position, Vec3d its_normal,
           double aspect) {
    deformed.Extend(expected.position);
    distance = std::max(distance, Norm(position - expected.position));
    if (!(aspect <= kMostAspect) || !(expected.kappa <= testing::kMostKappa)) return;
    const double angle = testing::Angle(its_normal, expected.normal);
    normal = std::max(normal, angle / (expected.kappa * aspect));
  }
  void Include(const ComparatorPrecision& other) {
    distance = std::max(distance, other.distance);
    normal = std::max(normal, other.normal);
    deformed.Extend(other.deformed);
    distinct_points = std::max(distinct_points, other.distinct_points);
  }
  // kInternal if an error is too large. Positions have the limit of GEMM pipelines.
  [[nodiscard]] absl::Status Check(double most_normal) const {
    if (position() <= testing::kGemmPosition && normal <= most_normal) return absl::OkStatus();
    return absl::InternalError(fmt::format(
        "position off by {:.2e} D, allowed {:.0e}; normal by {:.2e} rad per kappa and aspect, "
        "allowed {:.0e}",
        position(), testing::kGemmPosition, normal, most_normal));
  }
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_COMPARATOR_PRECISION_H_
