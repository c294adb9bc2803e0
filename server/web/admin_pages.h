// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pages for operators and their tools, on a port of their own. The API is never served there.
//
//   /healthz   200 while engine and workers move; 503 when only a restart will help. Says how many lines of the
//              log were dropped, because nobody reads it
//   /readyz    200 while gRPC health says SERVING: not while draining
//   /metrics   text for Prometheus, 404 without
// `http` counts the connections of --http.
// Threads  safe; hooks are called on any thread
#ifndef LATTICED_SERVER_WEB_ADMIN_PAGES_H_
#define LATTICED_SERVER_WEB_ADMIN_PAGES_H_

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "server/base/connection_counts.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

struct AdminHooks {
  std::function<absl::Status()> health;
  std::function<uint64_t()> dropped_log_lines;
  std::function<bool()> ready;
  std::function<std::string(const ConnectionCounts& http)> metrics;  // unset: no such page
};

[[nodiscard]] HttpResponse AdminAnswer(const AdminHooks& hooks, const HttpRequest& request,
                                       const ConnectionCounts& http);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_ADMIN_PAGES_H_
