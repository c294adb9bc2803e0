// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/constraint_converters.h"

#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/wire/enum_table.h"

namespace latticed {
namespace {

constexpr int kNoAxis = -1;
constexpr auto kConstraintAxes =
    std::to_array<std::pair<v1::LatticeAxis, int>>({{v1::LATTICE_AXIS_U, 0},
                                                    {v1::LATTICE_AXIS_V, 1},
                                                    {v1::LATTICE_AXIS_W, 2},
                                                    {v1::LATTICE_AXIS_UNSPECIFIED, kNoAxis}});
constexpr int kMostFaces = 6;

absl::StatusOr<std::optional<int>> ReadAxis(v1::LatticeAxis axis, const std::string& field) {
  LATTICED_ASSIGN_OR_RETURN(const int read, ReadEnum(kConstraintAxes, axis, field));
  return read == kNoAxis ? std::nullopt : std::optional(read);
}

}  // namespace

absl::StatusOr<KeptVolume> FromProto(const v1::KeptVolume& kept, std::string_view field) {
  KeptVolume result;
  LATTICED_ASSIGN_OR_RETURN(result.axis, ReadAxis(kept.axis(), fmt::format("{}.axis", field)));
  if (kept.has_volume()) result.volume = kept.volume();
  return result;
}

absl::StatusOr<Constraints> FromProto(const v1::Constraints& constraints, std::string_view field) {
  if (constraints.held_size() > limits::kMaxControlPoints) {
    return error::OutOfRange(fmt::format("{}.held", field), constraints.held_size(), 0,
                             limits::kMaxControlPoints);
  }
  if (constraints.held_layers_size() > kMostFaces) {
    return error::OutOfRange(fmt::format("{}.held_layers", field), constraints.held_layers_size(),
                             0, kMostFaces);
  }
  Constraints result{.held = {constraints.held().begin(), constraints.held().end()}};
  for (int n = 0; n < constraints.held_layers_size(); ++n) {
    const v1::HeldLayers& layers = constraints.held_layers(n);
    const std::string path = fmt::format("{}.held_layers[{}].axis", field, n);
    LATTICED_ASSIGN_OR_RETURN(const auto axis, ReadAxis(layers.axis(), path));
    if (!axis.has_value()) return error::InvalidField(path, "is required");
    result.held_layers.push_back({*axis, layers.at_end(), layers.layers()});
  }
  LATTICED_ASSIGN_OR_RETURN(result.mirror,
                            ReadAxis(constraints.mirror(), fmt::format("{}.mirror", field)));
  if (constraints.has_volume()) {
    LATTICED_ASSIGN_OR_RETURN(result.volume,
                              FromProto(constraints.volume(), fmt::format("{}.volume", field)));
  }
  return result;
}

v1::Constraints ToProto(const Constraints& constraints) {
  v1::Constraints result;
  result.mutable_held()->Add(constraints.held.begin(), constraints.held.end());
  for (const HeldLayers& layers : constraints.held_layers) {
    v1::HeldLayers& item = *result.add_held_layers();
    item.set_axis(WriteEnum(kConstraintAxes, layers.axis));
    item.set_at_end(layers.at_end);
    item.set_layers(layers.layers);
  }
  result.set_mirror(WriteEnum(kConstraintAxes, constraints.mirror.value_or(kNoAxis)));
  if (!constraints.volume.has_value()) return result;
  v1::KeptVolume& volume = *result.mutable_volume();
  volume.set_axis(WriteEnum(kConstraintAxes, constraints.volume->axis.value_or(kNoAxis)));
  if (constraints.volume->volume.has_value()) volume.set_volume(*constraints.volume->volume);
  return result;
}

}  // namespace latticed
