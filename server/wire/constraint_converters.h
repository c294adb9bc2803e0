// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Constraints of edits <-> core/ffd.
//
// Errors   kInvalidArgument with the path of the field
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_CONSTRAINT_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_CONSTRAINT_CONVERTERS_H_

#include <string_view>

#include "absl/status/statusor.h"
#include "core/ffd/constraints/constraints.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed {

// Checks what follows from the message: known enum values and counts. The scene checks the rest against its lattice.
[[nodiscard]] absl::StatusOr<Constraints> FromProto(const v1::Constraints& constraints,
                                                    std::string_view field);
[[nodiscard]] absl::StatusOr<KeptVolume> FromProto(const v1::KeptVolume& kept,
                                                   std::string_view field);
[[nodiscard]] v1::Constraints ToProto(const Constraints& constraints);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_CONSTRAINT_CONVERTERS_H_
