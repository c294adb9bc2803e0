// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_HELD_POINTS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_HELD_POINTS_H_

#include <string>

#include "latticed/v1/edit.pb.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

// Says how many of the control points that the edit names do not move, because the lattice's constraints hold them: one
// line, or "" for none. `before` is the lattice that the edit was made for. Pure.
[[nodiscard]] std::string HeldLine(const v1::Edit& edit, const v1::LatticeState& before);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_HELD_POINTS_H_
