// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decides who may use the server. A page of another site must not drive a local server, neither by its
// own requests (Origin, Sec-Fetch-Site) nor by a name that resolves to it (Host; "DNS rebinding").
//
//   Host     localhost, 127.0.0.1, [::1], the host of the listened address, --allowed-hosts; any
//            address where the server listens on all, since an address cannot be rebound
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

  // The answer to a request that is refused or is a preflight; nothing for one that may go on.
  [[nodiscard]] std::optional<HttpResponse> Stop(const HttpRequest& request) const;
  // The CORS fields that let a page of --cors-origin read an answer with those `fields`.
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
