// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who may ask: a page of another site must not drive a local server, neither by its own requests
// (Origin, Sec-Fetch-Site) nor by a name that it has made point here (Host; "DNS rebinding").
//
//   Host     localhost, 127.0.0.1, [::1], the host of the listened address, --allowed-hosts; where all
//            addresses are listened on any address, which cannot be made to point elsewhere
//   Origin   absent, the same host and port, or of --cors-origin
//
// Threads  immutable
#ifndef LATTICED_SERVER_WEB_REQUEST_GUARD_H_
#define LATTICED_SERVER_WEB_REQUEST_GUARD_H_

#include <optional>
#include <string>
#include <vector>

#include "server/web/http_exchange.h"

namespace latticed::web {

class RequestGuard {
 public:
  // `listen` as "host:port"; origins as "https://host[:port]".
  RequestGuard(const std::string& listen, const std::vector<std::string>& allowed_hosts,
               std::vector<std::string> cors_origins);

  // The answer to a request that goes no further: a refusal, or to a preflight.
  [[nodiscard]] std::optional<HttpResponse> Stop(const HttpRequest& request) const;
  // What an answer of those `fields` needs so that a page of --cors-origin may read it.
  [[nodiscard]] HttpFields CorsFields(const HttpRequest& request, const HttpFields& fields) const;

 private:
  bool HostAllowed(std::string_view host) const;
  bool OriginConfigured(std::string_view origin) const;
  HttpResponse Preflight(const HttpRequest& request) const;

  std::vector<std::string> hosts_;  // in lower case, without ports
  bool any_address_ = false;
  std::vector<std::string> cors_origins_;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_REQUEST_GUARD_H_
