// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/records/constraints_codec.h"

#include "server/store/records/lattice_codec.h"

namespace latticed {

void ToStored(const Constraints& constraints, store::Constraints& stored) {
  stored.mutable_held()->Add(constraints.held.begin(), constraints.held.end());
  for (const HeldLayers& layers : constraints.held_layers) {
    store::HeldLayers& item = *stored.add_held_layers();
    item.set_axis(static_cast<uint32_t>(layers.axis));
    item.set_at_end(layers.at_end);
    item.set_layers(static_cast<uint32_t>(layers.layers));
  }
  if (constraints.mirror.has_value()) {
    stored.set_mirror(static_cast<uint32_t>(*constraints.mirror));
  }
  if (!constraints.volume.has_value()) return;
  store::KeptVolume& volume = *stored.mutable_volume();
  if (constraints.volume->axis.has_value()) {
    volume.set_axis(static_cast<uint32_t>(*constraints.volume->axis));
  }
  if (constraints.volume->volume.has_value()) volume.set_volume(*constraints.volume->volume);
}

absl::StatusOr<Constraints> ConstraintsFromStored(const store::Constraints& stored) {
  constexpr uint32_t kMostAxis = 2;
  Constraints constraints{.held = {stored.held().begin(), stored.held().end()}};
  for (const store::HeldLayers& item : stored.held_layers()) {
    if (item.axis() > kMostAxis || item.layers() > static_cast<uint32_t>(kMostHeldLayers)) {
      return NotARecord("held layers");
    }
    constraints.held_layers.push_back(
        {static_cast<int>(item.axis()), item.at_end(), static_cast<int>(item.layers())});
  }
  if (stored.mirror() > kMostAxis || stored.volume().axis() > kMostAxis) {
    return NotARecord("the axis of a constraint");
  }
  if (stored.has_mirror()) constraints.mirror = static_cast<int>(stored.mirror());
  if (!stored.has_volume()) return constraints;
  KeptVolume& volume = constraints.volume.emplace();
  if (stored.volume().has_axis()) volume.axis = static_cast<int>(stored.volume().axis());
  if (stored.volume().has_volume()) volume.volume = stored.volume().volume();
  return constraints;
}

}  // namespace latticed
