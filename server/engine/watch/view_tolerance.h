// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether a scene can have a view, and whether the view can keep its tolerance on the present grid:
// core/adaptive/edge_levels.h.
//
// Errors   kInvalidArgument with the path of the field, which begins with the argument `field`: UNSUPPORTED where
//          views have no patches; OUT_OF_RANGE with the position bits that would meet it, or with the least
//          tolerance where none would
// Threads  pure functions
#ifndef LATTICED_SERVER_ENGINE_WATCH_VIEW_TOLERANCE_H_
#define LATTICED_SERVER_ENGINE_WATCH_VIEW_TOLERANCE_H_

#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/engine/render/target_slot.h"
#include "server/engine/watch/watch_view.h"

namespace latticed {

// Returns the view, with position bits that meet its tolerance where it has 0. A view without a tolerance or without
// positions is returned as it is.
[[nodiscard]] absl::StatusOr<WatchView> SettleTolerance(const WatchView& view,
                                                        const TargetSlot& target,
                                                        const QuantisationBox& box,
                                                        std::string_view field);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_VIEW_TOLERANCE_H_
