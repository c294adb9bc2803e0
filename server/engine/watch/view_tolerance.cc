// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watch/view_tolerance.h"

#include "core/adaptive/edge_levels.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// What a view gets that leaves its bits to the server: the least bits that meet the tolerance and whose point error is
// at most a third of it; the most bits where no point error is so small. A bit more than the least that meet it costs up
// to three bits a point, but leaves twice as much of the tolerance to curvature. That takes up to a quarter of the points
// away (tests/bench/results/tolerance.md).
int ChoosePositionBits(double tolerance, const QuantisationBox& box, int least_bits) {
  int bits = least_bits;
  while (bits < limits::kMaxPositionBits && 3 * PointError(box, bits) > tolerance) ++bits;
  return bits;
}

// The least tolerance that MeetsTolerance takes.
double LeastTolerance(const QuantisationBox& box, int position_bits) {
  return 1.5 * PointError(box, position_bits);
}

absl::Status TooSmall(double tolerance, double least, std::string_view how,
                      std::string_view field) {
  return error::InvalidField(fmt::format("{}.tolerance", field),
                             fmt::format("got {}, {} allow {:.3g} or more", tolerance, how, least),
                             "OUT_OF_RANGE");
}

}  // namespace

absl::StatusOr<WatchView> SettleTolerance(const WatchView& view, const TargetSlot& target,
                                          const QuantisationBox& box, std::string_view field) {
  if (!HasPositions(view.key.spec)) {
    if (target.has_edge_bounds()) return view;
    return error::NoPatches(fmt::format("{}.encoding", field));
  }
  const double tolerance = view.key.spec.tolerance;
  if (!(tolerance > 0)) return view;
  if (view.key.spec.format == VertexFormat::kFloat32) {
    if (MeetsTolerance(tolerance, box, 0)) return view;
    return TooSmall(tolerance, LeastTolerance(box, 0), "float32 positions", field);
  }
  const auto least_bits = LeastPositionBits(tolerance, box);
  if (!least_bits.has_value()) {
    return TooSmall(tolerance, LeastTolerance(box, limits::kMaxPositionBits),
                    fmt::format("{} position bits", limits::kMaxPositionBits), field);
  }
  WatchView settled = view;
  int& bits = settled.key.spec.position_bits;
  if (bits == 0) bits = ChoosePositionBits(tolerance, box, *least_bits);
  if (bits < *least_bits) {
    return error::InvalidField(
        fmt::format("{}.position_bits", field),
        fmt::format("got {}, a tolerance of {} needs {}", bits, tolerance, *least_bits),
        "OUT_OF_RANGE");
  }
  return settled;
}

}  // namespace latticed
