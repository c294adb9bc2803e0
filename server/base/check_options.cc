// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which options go together, and what follows from them.
#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "fmt/format.h"
#include "server/base/options.h"

namespace latticed {
namespace {

bool IsHostAndPort(const std::string& address) {
  const size_t colon = address.rfind(':');
  uint32_t port = 0;
  return colon != std::string::npos && colon > 0 && !IsUnixSocket(address) &&
         absl::SimpleAtoi(address.substr(colon + 1), &port) && port <= 65'535;
}

// Whether this is an origin as browsers write it: without a path, not even a slash.
bool IsOrigin(const std::string& origin) {
  const size_t host = origin.rfind("https://", 0) == 0  ? 8
                      : origin.rfind("http://", 0) == 0 ? 7
                                                        : 0;
  return host > 0 && origin.size() > host &&
         origin.find_first_of("/*? ", host) == std::string::npos;
}

absl::Status CheckWeb(const Options& o) {
  for (const auto& [flag, address] : {std::pair("--http", o.http), std::pair("--admin", o.admin)}) {
    if (!address.empty() && !IsHostAndPort(address)) {
      return absl::InvalidArgumentError(
          fmt::format("{}: got '{}', expected host:port, such as 127.0.0.1:8080", flag, address));
    }
  }
  for (const std::string& origin : o.cors_origins) {
    if (!IsOrigin(origin)) {
      return absl::InvalidArgumentError(fmt::format(
          "--cors-origin: got '{}', expected a site such as https://app.example", origin));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckOpenPorts(const Options& o) {
  if (!o.tls_cert.empty() || NeedsTokens(o) || o.insecure) return absl::OkStatus();
  for (const auto& [flag, address] :
       {std::pair("--listen", o.listen), std::pair("--http", o.http)}) {
    if (address.empty() || IsLoopback(address)) continue;
    return absl::InvalidArgumentError(
        fmt::format("{}: '{}' is open to others, so give --tls-cert and --tls-key, or "
                    "--token-file or --jwks-file; or --insecure if that is what you want",
                    flag, address));
  }
  return absl::OkStatus();
}

// A name stands in headers, and in the proxy's configuration.
bool IsServerName(std::string_view name) {
  constexpr size_t kMostBytes = 64;
  return name.size() <= kMostBytes && std::ranges::all_of(name, [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' ||
                  c == '.' || c == ':';
         });
}

absl::Status CheckStore(const Options& o) {
  const std::pair<std::string_view, const std::string&> needed[] = {
      {"--store-url-file", o.store_url_file},
      {"--mesh-store", o.mesh_store},
      {"--advertise", o.advertise}};
  const bool shared = o.store == "postgres";
  for (const auto& [flag, value] : needed) {
    if (shared && value.empty()) {
      return absl::InvalidArgumentError(fmt::format("--store postgres needs {}", flag));
    }
    if (!shared && !value.empty() && flag != "--advertise") {
      return absl::InvalidArgumentError(fmt::format("{} is for --store postgres", flag));
    }
  }
  if (!o.s3_endpoint.empty() && !o.mesh_store.starts_with("s3://")) {
    return absl::InvalidArgumentError("--s3-endpoint is for --mesh-store s3://BUCKET");
  }
  if (shared && !o.data_dir.empty()) {
    return absl::InvalidArgumentError("--data-dir is for --store sqlite");
  }
  if (!IsServerName(o.advertise)) {
    return absl::InvalidArgumentError(fmt::format(
        "--advertise: got '{}', expected at most 64 letters, digits and . - _ :", o.advertise));
  }
  return absl::OkStatus();
}

absl::Status CheckDurations(const Options& o) {
  struct Range {
    std::string_view flag;
    absl::Duration value, lowest, highest;
  };
  const Range ranges[] = {
      {"--heartbeat-interval", o.heartbeat_interval, absl::Milliseconds(100), absl::Minutes(10)},
      {"--first-message-timeout", o.first_message_timeout, absl::Milliseconds(100), absl::Hours(1)},
      {"--write-timeout", o.write_timeout, absl::Milliseconds(100), absl::Hours(1)},
      {"--lease", o.lease, absl::Milliseconds(200), absl::Minutes(1)},
      {"--drain-delay", o.drain_delay, absl::ZeroDuration(), absl::Minutes(10)},
      {"--drain-timeout", o.drain_timeout, absl::ZeroDuration(), absl::Hours(1)},
      {"--scene-idle-ttl", o.scene_idle_ttl, absl::Seconds(1), absl::Hours(24 * 365)}};
  for (const auto& [flag, value, lowest, highest] : ranges) {
    if (value >= lowest && value <= highest) continue;
    return absl::InvalidArgumentError(
        fmt::format("{}: got {}, allowed is {} to {}", flag, absl::FormatDuration(value),
                    absl::FormatDuration(lowest), absl::FormatDuration(highest)));
  }
  return absl::OkStatus();
}

}  // namespace

bool IsUnixSocket(std::string_view address) { return address.starts_with("unix:"); }

bool IsLoopback(std::string_view listen) {
  if (IsUnixSocket(listen)) return true;
  const std::string_view host = listen.substr(0, listen.rfind(':'));
  if (host == "localhost" || host == "[::1]") return true;
  // Accepts 127.x.y.z, but not 127.example.com.
  return host.starts_with("127.") &&
         host.find_first_not_of("0123456789.") == std::string_view::npos;
}

size_t MostConnections(const Options& options) {
  const uint64_t asked =
      options.max_connections > 0
          ? static_cast<uint64_t>(options.max_connections)
          : std::min<uint64_t>(options.transport_memory_bytes / limits::kConnectionBytes,
                               limits::kMaxConnections);
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return std::max<uint64_t>(asked, 1);
  const uint64_t own = std::min<uint64_t>(files.rlim_cur, limits::kOwnFiles);
  const uint64_t ports = options.http.empty() ? 1 : 2;
  return std::max<uint64_t>(std::min<uint64_t>(asked, (files.rlim_cur - own) / ports), 1);
}

size_t MostOfAddress(const Options& options) {
  const size_t most = MostConnections(options);
  if (options.trust_forwarded_for) return most;
  return std::max<size_t>(static_cast<size_t>(options.caller_share * static_cast<double>(most)), 1);
}

bool NeedsTokens(const Options& options) {
  return !options.token_file.empty() || !options.jwks_file.empty();
}

bool CountsLoopback(const Options& options) { return NeedsTokens(options); }

absl::Status Validate(const Options& o) {
  if (!IsUnixSocket(o.listen) && o.listen.rfind(':') == std::string::npos) {
    return absl::InvalidArgumentError(
        fmt::format("--listen: got '{}', expected host:port, such as 127.0.0.1:50151", o.listen));
  }
  if (o.tls_cert.empty() != o.tls_key.empty()) {
    return absl::InvalidArgumentError("--tls-cert and --tls-key go together");
  }
  if (!o.tls_client_ca.empty() && o.tls_cert.empty()) {
    return absl::InvalidArgumentError("--tls-client-ca needs --tls-cert and --tls-key");
  }
  if (o.jwks_file.empty() != o.jwt_issuer.empty() ||
      o.jwks_file.empty() != o.jwt_audience.empty()) {
    return absl::InvalidArgumentError("--jwks-file, --jwt-issuer and --jwt-audience go together");
  }
  if (absl::Status status = CheckWeb(o); !status.ok()) return status;
  if (absl::Status status = CheckOpenPorts(o); !status.ok()) return status;
  if (absl::Status status = CheckStore(o); !status.ok()) return status;
  if (o.max_mesh_bytes == 0 || o.max_mesh_bytes > limits::kMaxMeshBytes) {
    return absl::InvalidArgumentError(fmt::format("--max-mesh-bytes: got {}, allowed is 1 to {}",
                                                  o.max_mesh_bytes, limits::kMaxMeshBytes));
  }
  if (o.memory_bytes == 0) return absl::InvalidArgumentError("--memory: must be above 0");
  if (o.transport_memory_bytes < limits::kMinTransportBytes) {
    return absl::InvalidArgumentError(
        fmt::format("--transport-memory: got {}, allowed is {} or more", o.transport_memory_bytes,
                    limits::kMinTransportBytes));
  }
  return CheckDurations(o);
}

}  // namespace latticed
