// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What goes on outside a lattice's frame, to and from latticed.v1.
//
// Errors   kInvalidArgument with the path of the field, "lattices[0].lattice.outside.widths"
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_OUTSIDE_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_OUTSIDE_CONVERTERS_H_

#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/ffd/outside/outside.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed {

// As it is given: ResolvedOutside (core/ffd/outside/outside_rules.h) fills in the rest.
[[nodiscard]] absl::StatusOr<Outside> FromProto(const v1::LatticeOutside& outside,
                                                std::string_view field);
// Where no mesh says how far a linear one goes: an error if it has no widths.
[[nodiscard]] absl::Status CheckHasWidths(const v1::LatticeOutside& outside,
                                          std::string_view field);
[[nodiscard]] v1::LatticeOutside ToProto(const Outside& outside);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_OUTSIDE_CONVERTERS_H_
