// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The Bézier control nets of all patches as one file.
//
// Layout   little endian: "LATTNETS", uint32 version 1, uint32 degree n, uint32 m = (n+1)(n+2)/2, uint32 0, uint64
//          patches; then m x 3 doubles a patch, T_{n,0,0} first
// Units    world units
// Errors   kResourceExhausted from the backend, what `stop` returns
// Threads  a pure function of an immutable state
#ifndef LATTICED_SERVER_ENGINE_EXPORTS_CONTROL_NETS_H_
#define LATTICED_SERVER_ENGINE_EXPORTS_CONTROL_NETS_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/engine/exports/surface_export.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<std::string> WriteControlNets(const RenderInput& input,
                                                           StopCheck stop);
// What that takes at its peak.
[[nodiscard]] uint64_t ControlNetsBytes(const DeformPlan& plan);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_EXPORTS_CONTROL_NETS_H_
