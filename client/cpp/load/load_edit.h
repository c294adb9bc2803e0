// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_EDIT_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_EDIT_H_

#include <cstdint>

#include "latticed/v1/edit.pb.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

// Edit number `step`. It moves control points by a tenth of the lattice's first edge, and the next
// edit of the same points moves them back. A long run does not drift.
[[nodiscard]] v1::EditBatch MakeLoadEdit(const v1::LatticeState& lattice, bool all_points,
                                         uint64_t step);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_EDIT_H_
