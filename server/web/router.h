// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What --http answers: the guard may stop a request, then its path and method choose the handler.
//
// Threads  safe; requests come on the strands of their connections
#ifndef LATTICED_SERVER_WEB_ROUTER_H_
#define LATTICED_SERVER_WEB_ROUTER_H_

#include <memory>

#include "absl/time/time.h"
#include "server/base/options.h"
#include "server/base/refusal_log.h"
#include "server/web/generic_call.h"
#include "server/web/http_exchange.h"
#include "server/web/request_guard.h"
#include "server/web/static_files.h"

namespace latticed::web {

// Outlives the connections whose requests it answers.
class Router {
 public:
  Router(const Options& options, ServerChannel server);
  void Answer(const std::shared_ptr<HttpExchange>& exchange);
  // Logs the stopped requests that were only counted, of periods that have ended by `now`.
  void LogSums(absl::Time now);

 private:
  void LogStopped(const HttpRequest& request, int status);

  const ServerChannel server_;
  const RequestGuard guard_;
  const StaticFiles files_;
  RefusalLog refusals_;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_ROUTER_H_
