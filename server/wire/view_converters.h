// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of latticed.v1 <-> types of core.
//
// Errors   kInvalidArgument with the path of the field, which begins with the argument `field`;
//          reason UNSUPPORTED for an enum value that this server does not know
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_VIEW_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_VIEW_CONVERTERS_H_

#include <string_view>

#include "absl/status/statusor.h"
#include "latticed/v1/view.pb.h"
#include "server/engine/watch/watch_view.h"

namespace latticed {

// Views. DefaultView is what ViewOptions documents, with smooth or facet normals. In all of them, position_bits are 0
// where a tolerance is to choose them: server/engine/watch/view_tolerance.h.
[[nodiscard]] WatchView DefaultView(bool smooth);
// What is 0 or UNSPECIFIED comes from `defaults`. For a scene's default view.
[[nodiscard]] absl::StatusOr<WatchView> DefaultViewFromProto(const v1::ViewOptions& options,
                                                             const WatchView& defaults,
                                                             std::string_view field);
// The same for a watcher. Numbers that have no effect are set to the defaults, so that views with the same
// result are one view.
[[nodiscard]] absl::StatusOr<WatchView> WatchViewFromProto(const v1::ViewOptions& options,
                                                           const WatchView& defaults,
                                                           std::string_view field);
[[nodiscard]] v1::ViewOptions ToProto(const WatchView& view);

// UNSPECIFIED: `unspecified`. `field` is the whole path.
[[nodiscard]] absl::StatusOr<NormalMode> NormalModeFromProto(v1::NormalMode mode,
                                                             NormalMode unspecified,
                                                             std::string_view field);
[[nodiscard]] v1::NormalMode ToProto(NormalMode mode);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_VIEW_CONVERTERS_H_
