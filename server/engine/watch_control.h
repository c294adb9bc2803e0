// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Controls a running watch: by messages of its own Deform stream, or by ControlWatch.
//
// Threads  safe
#ifndef LATTICED_SERVER_ENGINE_WATCH_CONTROL_H_
#define LATTICED_SERVER_ENGINE_WATCH_CONTROL_H_

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "server/engine/scene/presence.h"
#include "server/engine/watch/watch_view.h"

namespace latticed {

class Scene;

struct WatchCommand {
  std::optional<uint64_t> acked_update_id;
  std::optional<WatchView> view;
  std::optional<bool> pause;
  std::optional<Presence> presence;  // an empty editor_id means that of the watch
};

class WatchControl {
 public:
  virtual ~WatchControl() = default;
  virtual const Scene& scene() const = 0;
  // Applies all of the command or nothing. An empty command shows that the client is alive.
  // kInvalidArgument, kResourceExhausted, kNotFound when the watch has ended.
  [[nodiscard]] virtual absl::Status Control(const WatchCommand& command) = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_CONTROL_H_
