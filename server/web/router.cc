// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/router.h"

#include <utility>

#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/web/deform_socket.h"
#include "server/web/export_download.h"
#include "server/web/grpc_web_call.h"

namespace latticed::web {

Router::Router(const Options& options, ServerChannel server)
    : server_(std::move(server)),
      guard_(options.http, options.allowed_hosts, options.cors_origins),
      files_(StaticFiles::FindRoot(options.web_root)) {}

void Router::Answer(const std::shared_ptr<HttpExchange>& exchange) const {
  const HttpRequest& request = exchange->request();
  if (auto stopped = guard_.Stop(request); stopped.has_value()) {
    LogEvent(spdlog::level::info, "HTTP request stopped",
             {{"status", fmt::to_string(stopped->status)},
              {"peer", request.peer},
              {"host", std::string(request.Field("host"))},
              {"origin", std::string(request.Field("origin"))}});
    return exchange->Reply(*std::move(stopped));
  }
  if (request.path == kDeformSocketPath) return OpenDeformSocket(server_, exchange);
  if (request.path.starts_with(kExportPrefix)) return RunExportDownload(server_, guard_, exchange);
  if (request.method == "POST") return RunGrpcWebCall(server_, guard_, exchange);
  files_.Answer(exchange);
}

}  // namespace latticed::web
