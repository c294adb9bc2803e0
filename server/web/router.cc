// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/router.h"

#include <utility>

#include "absl/time/clock.h"
#include "fmt/format.h"
#include "server/base/address.h"
#include "server/base/telemetry.h"
#include "server/web/deform_socket.h"
#include "server/web/export_download.h"
#include "server/web/grpc_web_call.h"

namespace latticed::web {

Router::Router(const Options& options, ServerChannel server)
    : server_(std::move(server)),
      guard_(options.http, options.allowed_hosts, options.cors_origins),
      files_(StaticFiles::FindRoot(options.web_root)) {}

// A sum is told with the next refusal after its period, or when the server ends.
void Router::LogStopped(const HttpRequest& request, int status) {
  const absl::Time now = absl::Now();
  LogSums(now);
  constexpr size_t kMostOriginBytes = 64;
  const std::string_view origin = request.Field("origin").substr(0, kMostOriginBytes);
  if (!refusals_.Note(WithoutPort(request.peer), origin, status, now)) return;
  LogEvent(spdlog::level::info, "HTTP request stopped",
           {{"status", fmt::to_string(status)},
            {"peer", request.peer},
            {"host", std::string(request.Field("host"))},
            {"origin", std::string(request.Field("origin"))}});
}

void Router::LogSums(absl::Time now) {
  for (const RefusalLog::Sum& sum : refusals_.TakeEnded(now)) {
    LogEvent(spdlog::level::info, "more HTTP requests were stopped",
             {{"requests", fmt::to_string(sum.count)},
              {"status", fmt::to_string(sum.code)},
              {"origin", sum.rpc},
              {"peer", sum.address}});
  }
}

void Router::Answer(const std::shared_ptr<HttpExchange>& exchange) {
  const HttpRequest& request = exchange->request();
  if (auto stopped = guard_.Stop(request); stopped.has_value()) {
    LogStopped(request, stopped->status);
    return exchange->Reply(*std::move(stopped));
  }
  if (request.path == kDeformSocketPath) return OpenDeformSocket(server_, exchange);
  if (request.path.starts_with(kExportPrefix)) return RunExportDownload(server_, guard_, exchange);
  if (request.method == "POST") return RunGrpcWebCall(server_, guard_, exchange);
  files_.Answer(exchange);
}

}  // namespace latticed::web
