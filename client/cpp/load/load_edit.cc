// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_edit.h"

#include <cmath>

namespace latticed::client {

v1::EditBatch MakeLoadEdit(const v1::LatticeState& state, bool all_points, uint64_t step) {
  const v1::Lattice& lattice = state.lattice();
  const auto points = static_cast<uint32_t>(lattice.control_points_size()) / 3;
  const v1::Vec3& edge = lattice.frame().u();
  const double reach =
      0.1 * std::sqrt(edge.x() * edge.x() + edge.y() * edge.y() + edge.z() * edge.z());
  v1::EditBatch batch;
  batch.set_structure_id(state.structure_id());
  auto* move = batch.add_edits()->mutable_move_control_points();
  if (all_points) {
    for (uint32_t i = 1; i < points; i += 2) move->add_indices(i);
  } else {
    move->add_indices(static_cast<uint32_t>(step % points));
  }
  const uint64_t turn = all_points ? step : step / points;
  move->mutable_offset()->set_z(turn % 2 == 0 ? reach : -reach);
  return batch;
}

}  // namespace latticed::client
