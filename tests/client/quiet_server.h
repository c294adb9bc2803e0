// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A real server in this process, on the CPU, without a log.
#ifndef LATTICED_TESTS_CLIENT_QUIET_SERVER_H_
#define LATTICED_TESTS_CLIENT_QUIET_SERVER_H_

#include <memory>
#include <utility>

#include "server/in_process.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {

inline Options QuietOptions() {
  Options options;
  options.backend = "cpu";
  options.log_level = "off";
  options.drain_delay = absl::ZeroDuration();
  return options;
}

// Null if the server does not start; the test then fails.
inline std::unique_ptr<InProcessServer> StartServer(const Options& options = QuietOptions()) {
  auto server = InProcessServer::Start(options);
  EXPECT_OK(server);
  return server.ok() ? *std::move(server) : nullptr;
}

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_QUIET_SERVER_H_
