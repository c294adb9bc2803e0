// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Presences <-> messages.
//
// Errors   kInvalidArgument with the path of the field, which begins with "presence"
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_PRESENCE_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_PRESENCE_CONVERTERS_H_

#include "absl/status/statusor.h"
#include "latticed/v1/event.pb.h"
#include "server/engine/scene/presence.h"

namespace latticed {

// Checks sizes and ranges. The watch knows whose presence it is.
[[nodiscard]] absl::StatusOr<Presence> FromProto(const v1::Presence& presence);
[[nodiscard]] v1::Presence ToProto(const Presence& presence);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_PRESENCE_CONVERTERS_H_
