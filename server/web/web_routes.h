// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which request of --http goes where, after the guard.
//
// Threads  safe
#ifndef LATTICED_SERVER_WEB_WEB_ROUTES_H_
#define LATTICED_SERVER_WEB_WEB_ROUTES_H_

#include <memory>

#include "server/base/options.h"
#include "server/web/generic_call.h"
#include "server/web/http_exchange.h"
#include "server/web/request_guard.h"
#include "server/web/static_files.h"

namespace latticed::web {

class WebRoutes {
 public:
  WebRoutes(const Options& options, ServerChannel server);
  WebRoutes(const WebRoutes&) = delete;  // its handler has its address
  WebRoutes& operator=(const WebRoutes&) = delete;

  HttpHandler handler() const {
    return [this](const std::shared_ptr<HttpExchange>& exchange) { Route(exchange); };
  }

 private:
  void Route(const std::shared_ptr<HttpExchange>& exchange) const;

  const ServerChannel server_;
  const RequestGuard guard_;
  const StaticFiles files_;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_WEB_ROUTES_H_
