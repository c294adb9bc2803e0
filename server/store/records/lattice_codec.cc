// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/records/lattice_codec.h"

#include <algorithm>
#include <string>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

void ToStored(const Outside& outside, store::Outside& stored) {
  stored.set_mode(static_cast<uint32_t>(outside.mode));
  stored.set_smooth(outside.smooth);
  stored.mutable_widths()->Add(outside.widths.begin(), outside.widths.end());
  stored.mutable_steps()->Add(outside.steps.begin(), outside.steps.end());
}

absl::StatusOr<Outside> OutsideFromStored(const store::Outside& stored) {
  Outside outside;
  const auto most = static_cast<uint32_t>(OutsideMode::kLinear);
  if (stored.mode() > most || stored.widths_size() != static_cast<int>(outside.widths.size()) ||
      stored.steps_size() != static_cast<int>(outside.steps.size())) {
    return NotARecord("what is outside a lattice");
  }
  outside.mode = static_cast<OutsideMode>(stored.mode());
  outside.smooth = stored.smooth();
  std::copy(stored.widths().begin(), stored.widths().end(), outside.widths.begin());
  std::copy(stored.steps().begin(), stored.steps().end(), outside.steps.begin());
  return outside;
}

}  // namespace

absl::Status NotARecord(std::string_view what) {
  return absl::DataLossError(fmt::format("not a record of a scene: {}", what));
}

void ToStored(const std::vector<Vec3d>& points, google::protobuf::RepeatedField<double>& flat) {
  flat.Reserve(static_cast<int>(3 * points.size()));
  for (const Vec3d& point : points) {
    for (int axis = 0; axis < 3; ++axis) flat.Add(point[axis]);
  }
}

absl::StatusOr<std::vector<Vec3d>> PointsFromStored(
    const google::protobuf::RepeatedField<double>& flat) {
  if (flat.size() % 3 != 0) return NotARecord("positions");
  std::vector<Vec3d> points(static_cast<size_t>(flat.size()) / 3);
  for (size_t n = 0; n < points.size(); ++n) {
    const double* xyz = flat.data() + 3 * n;
    points[n] = {xyz[0], xyz[1], xyz[2]};
  }
  return points;
}

void ToStored(const Lattice& lattice, store::Lattice& stored) {
  const LatticeStructure& structure = lattice.structure;
  for (const int degree : structure.degree) stored.add_degree(static_cast<uint32_t>(degree));
  for (const int size : structure.size) stored.add_size(static_cast<uint32_t>(size));
  stored.mutable_knots_u()->Add(structure.knots[0].begin(), structure.knots[0].end());
  stored.mutable_knots_v()->Add(structure.knots[1].begin(), structure.knots[1].end());
  stored.mutable_knots_w()->Add(structure.knots[2].begin(), structure.knots[2].end());
  const LatticeFrame& frame = structure.frame;
  ToStored({frame.origin, frame.edges[0], frame.edges[1], frame.edges[2]}, *stored.mutable_frame());
  ToStored(lattice.control_points, *stored.mutable_control_points());
  if (structure.outside != Outside{}) ToStored(structure.outside, *stored.mutable_outside());
}

absl::StatusOr<Lattice> LatticeFromStored(const store::Lattice& stored) {
  if (stored.degree_size() != 3 || stored.size_size() != 3) return NotARecord("a lattice's size");
  Lattice lattice;
  LatticeStructure& structure = lattice.structure;
  for (int axis = 0; axis < 3; ++axis) {
    structure.degree[static_cast<size_t>(axis)] = static_cast<int>(stored.degree(axis));
    structure.size[static_cast<size_t>(axis)] = static_cast<int>(stored.size(axis));
  }
  structure.knots = {std::vector<double>(stored.knots_u().begin(), stored.knots_u().end()),
                     std::vector<double>(stored.knots_v().begin(), stored.knots_v().end()),
                     std::vector<double>(stored.knots_w().begin(), stored.knots_w().end())};
  LATTICED_ASSIGN_OR_RETURN(const auto frame, PointsFromStored(stored.frame()));
  if (frame.size() != 4) return NotARecord("a lattice's frame");
  structure.frame = {frame[0], {frame[1], frame[2], frame[3]}};
  if (stored.has_outside()) {
    LATTICED_ASSIGN_OR_RETURN(structure.outside, OutsideFromStored(stored.outside()));
  }
  LATTICED_ASSIGN_OR_RETURN(lattice.control_points, PointsFromStored(stored.control_points()));
  return lattice;
}

}  // namespace latticed
