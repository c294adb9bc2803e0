// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_CPP_LIBRARY_RETRIES_WITH_RETRIES_H_
#define LATTICED_CLIENT_CPP_LIBRARY_RETRIES_WITH_RETRIES_H_

#include <functional>
#include <stop_token>

#include "absl/status/status.h"
#include "client/cpp/library/retries/reachability.h"

namespace latticed::client {

// Calls a function, which makes an idempotent call on the channel, until it succeeds or Attempts has no other attempt.
// Returns the last status. A request of `stop` ends a pause; no attempt follows.
[[nodiscard]] absl::Status WithRetries(Reachability* server, grpc::Channel& channel,
                                       const std::stop_token& stop,
                                       const std::function<absl::Status()>& call);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_RETRIES_WITH_RETRIES_H_
