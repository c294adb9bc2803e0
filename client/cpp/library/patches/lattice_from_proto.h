// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_LATTICE_FROM_PROTO_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_LATTICE_FROM_PROTO_H_

#include <span>

#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "latticed/v1/common.pb.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

[[nodiscard]] Vec3d FromProto(const v1::Vec3& proto);
// A lattice whose missing fields have the defaults of the protocol. Errors: those of Validate(Lattice), as a server
// would report them.
// `mesh` has the points of the rest world that a linear continuation without widths reaches. A server has filled them in.
[[nodiscard]] absl::StatusOr<Lattice> FromProto(const v1::Lattice& proto,
                                                std::span<const Vec3d> mesh = {});
// The lattice by which a scene at this state is deformed: rest + strength (P - rest), with the control points P of the state
// and rest, its identity. For PatchEvaluator. Errors: of FromProto; a strength that is not 0 to 1.
[[nodiscard]] absl::StatusOr<Lattice> EffectiveLattice(const v1::LatticeState& state);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_LATTICE_FROM_PROTO_H_
