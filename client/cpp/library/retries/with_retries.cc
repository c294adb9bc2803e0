// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/retries/with_retries.h"

#include "client/cpp/library/retries/attempts.h"

namespace latticed::client {

absl::Status WithRetries(Reachability* server, grpc::Channel& channel, const std::stop_token& stop,
                         const std::function<absl::Status()>& call) {
  Attempts attempts(server);
  for (;;) {
    const absl::Status status = call();
    if (status.ok()) attempts.Succeeded();
    if (status.ok() || stop.stop_requested()) return status;
    const auto pause = attempts.PauseAfter(status);
    if (!pause.has_value()) return status;
    Reachability::Wait(channel, *pause, [&stop] { return stop.stop_requested(); });
    if (stop.stop_requested()) return status;
  }
}

}  // namespace latticed::client
