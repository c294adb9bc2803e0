// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/admin_pages.h"

#include "fmt/format.h"
#include "server/web/http_answers.h"

namespace latticed::web {

HttpResponse AdminAnswer(const AdminHooks& hooks, const HttpRequest& request,
                         const ConnectionCounts& http) {
  if (request.method != "GET" && request.method != "HEAD") return MethodNotAllowed("GET, HEAD");
  if (request.path == "/healthz") {
    const absl::Status health = hooks.health();
    if (!health.ok()) return TextAnswer(503, std::string(health.message()));
    const uint64_t dropped = hooks.dropped_log_lines();
    return TextAnswer(
        200, dropped == 0 ? "ok" : fmt::format("ok; {} lines of the log were dropped", dropped));
  }
  if (request.path == "/readyz") {
    return hooks.ready() ? TextAnswer(200, "ready") : TextAnswer(503, "not serving");
  }
  if (request.path == "/metrics" && hooks.metrics) {
    HttpResponse answer;
    answer.fields = {{"content-type", "text/plain; version=0.0.4; charset=utf-8"}};
    answer.body = hooks.metrics(http);
    return answer;
  }
  return TextAnswer(404, "here are /healthz, /readyz and, where it is built in, /metrics");
}

}  // namespace latticed::web
