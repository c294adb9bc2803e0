// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/request_guard.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/ascii.h"
#include "fmt/format.h"
#include "server/web/http_answers.h"

namespace latticed::web {
namespace {

constexpr std::string_view kPreflightSeconds = "7200";

std::string Lower(std::string_view text) { return absl::AsciiStrToLower(std::string(text)); }

// "localhost:8080" -> "localhost", "[::1]:8080" -> "[::1]".
std::string HostOf(std::string_view authority) {
  const size_t bracket = authority.rfind(']');
  const size_t colon = authority.rfind(':');
  const bool has_port =
      colon != std::string_view::npos && (bracket == std::string_view::npos || bracket < colon);
  return Lower(has_port ? authority.substr(0, colon) : authority);
}

bool IsAddress(std::string host) {
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  std::array<unsigned char, sizeof(in6_addr)> address{};
  return inet_pton(AF_INET, host.c_str(), address.data()) == 1 ||
         inet_pton(AF_INET6, host.c_str(), address.data()) == 1;
}

// Whether `origin` names the request's host. A server without TLS also accepts its https origin, because a proxy
// in front of it may end TLS. A server with TLS accepts no http origin.
bool SameOrigin(std::string_view origin, std::string_view host, bool secure) {
  constexpr std::string_view kPlain = "http://";
  constexpr std::string_view kSecure = "https://";
  if (origin.starts_with(kSecure)) return Lower(origin.substr(kSecure.size())) == Lower(host);
  return !secure && origin.starts_with(kPlain) &&
         Lower(origin.substr(kPlain.size())) == Lower(host);
}

// Browsers send no Origin for images, scripts and frames, but Sec-Fetch-Site says where the request comes from.
// Following a link is allowed.
bool FromForeignPage(const HttpRequest& request) {
  const std::string_view site = request.Field("sec-fetch-site");
  const bool own = site.empty() || site == "same-origin" || site == "none";
  return !own && request.Field("sec-fetch-mode") != "navigate";
}

}  // namespace

RequestGuard::RequestGuard(const std::string& listen, const std::vector<std::string>& allowed_hosts,
                           std::vector<std::string> cors_origins)
    : hosts_{"localhost", "127.0.0.1", "[::1]"}, cors_origins_(std::move(cors_origins)) {
  const std::string host = HostOf(listen);
  any_address_ = host == "0.0.0.0" || host == "[::]";
  hosts_.push_back(host);
  for (const std::string& allowed : allowed_hosts) hosts_.push_back(HostOf(allowed));
}

bool RequestGuard::HostAllowed(std::string_view host) const {
  const std::string name = HostOf(host);
  return std::ranges::find(hosts_, name) != hosts_.end() || (any_address_ && IsAddress(name));
}

bool RequestGuard::OriginConfigured(std::string_view origin) const {
  return std::ranges::find(cors_origins_, origin) != cors_origins_.end();
}

std::optional<HttpResponse> RequestGuard::Stop(const HttpRequest& request) const {
  const std::string_view host = request.Field("host");
  if (!HostAllowed(host)) {
    return TextAnswer(403, fmt::format("'{}' is not a host name of this server; its operator may "
                                       "add it to --allowed-hosts",
                                       host));
  }
  const std::string_view origin = request.Field("origin");
  const bool configured = OriginConfigured(origin);
  const bool foreign = origin.empty() ? FromForeignPage(request)
                                      : !configured && !SameOrigin(origin, host, request.secure);
  if (foreign) {
    return TextAnswer(403, fmt::format("pages of '{}' may not use this server; its operator may "
                                       "add them to --cors-origin",
                                       origin.empty() ? "another site" : origin));
  }
  if (configured && request.method == "OPTIONS") return Preflight(request);
  return std::nullopt;
}

HttpResponse RequestGuard::Preflight(const HttpRequest& request) const {
  HttpResponse answer{.status = 204};
  answer.fields = {{"access-control-allow-origin", std::string(request.Field("origin"))},
                   {"access-control-allow-methods", "GET, POST"},
                   {"access-control-max-age", std::string(kPreflightSeconds)},
                   {"vary", "origin"}};
  const std::string_view asked = request.Field("access-control-request-headers");
  if (!asked.empty()) answer.fields.push_back({"access-control-allow-headers", std::string(asked)});
  if (request.Field("access-control-request-private-network") == "true") {
    answer.fields.push_back({"access-control-allow-private-network", "true"});
  }
  return answer;
}

HttpFields RequestGuard::CorsFields(const HttpRequest& request, const HttpFields& fields) const {
  if (cors_origins_.empty()) return {};
  HttpFields result = {{"vary", "origin"}};
  const std::string_view origin = request.Field("origin");
  if (!OriginConfigured(origin)) return result;
  std::string exposed;
  for (const HttpField& field : fields) exposed += (exposed.empty() ? "" : ", ") + field.name;
  result.push_back({"access-control-allow-origin", std::string(origin)});
  if (!exposed.empty()) result.push_back({"access-control-expose-headers", exposed});
  return result;
}

}  // namespace latticed::web
