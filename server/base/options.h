// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options of the daemon: flags, environment (LATTICED_*) and config file, from one table
// (options.cc). Flags win over the environment, the environment over the file.
//
// Units    bytes; durations as absl::Duration ("500ms", "10s", "24h" on the command line)
// Threads  plain data; immutable once the server starts
#ifndef LATTICED_SERVER_BASE_OPTIONS_H_
#define LATTICED_SERVER_BASE_OPTIONS_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/limits.h"
#include "core/view/device_group.h"

namespace latticed {

// How long an HTTP client may keep its connection waiting before it is closed.
struct HttpTimeouts {
  using Duration = std::chrono::steady_clock::duration;

  Duration head = std::chrono::seconds(10);    // for a handshake, and for the head of a request
  Duration body = std::chrono::seconds(60);    // between pieces of a body
  Duration write = std::chrono::minutes(5);    // to take what one write sends
  Duration idle = std::chrono::seconds(75);    // between requests
  Duration linger = std::chrono::seconds(5);   // to stop sending, after the last answer
  Duration silence = std::chrono::minutes(5);  // of a WebSocket; pings are sent at half of it
};

struct Options {
  std::string listen = "127.0.0.1:50151";  // host:port; port 0 takes a free one
  std::string backend = "auto";            // auto, cpu or cuda: server/backends.h
  int threads = 0;  // of the CPU backend, and those that encode; 0: all that the machine allows
  std::vector<int> devices{0};                  // CUDA devices; each scene goes to the freest
  uint64_t span_patches = kDefaultSpanPatches;  // a scene of so many patches takes all devices
  uint64_t gpu_memory_bytes = 0;  // budget of each device; 0: nine tenths of what is free
  uint64_t memory_bytes = uint64_t{4} << 30;            // host budget: meshes, plans, chunks
  uint64_t transport_memory_bytes = uint64_t{1} << 30;  // what gRPC may buffer for all connections
  uint64_t max_mesh_bytes = uint64_t{1} << 30;          // largest single upload
  int max_connections = 0;  // of listen, and of http; 0: as many as transport memory allows
  int max_scenes = limits::kDefaultMaxScenes;
  int max_watchers = limits::kDefaultMaxWatchersPerScene;  // of one scene
  std::string store = "sqlite";  // sqlite, in data_dir; or postgres, which servers share
  std::string data_dir;          // folder of meshes, scenes and edits; empty: memory only
  std::string store_url_file;    // of postgres: a file with the database's URL
  std::string
      mesh_store;  // of postgres: the meshes' folder, which all servers see; or s3://BUCKET/PREFIX
  std::string s3_endpoint;  // of that bucket: https://host:port; empty: Amazon's
  std::string s3_region = "us-east-1";
  std::string advertise;  // of postgres: this server's name to proxies
  absl::Duration lease =
      absl::Milliseconds(800);             // of postgres: how long others wait for this server
  std::string durability = "full";         // full or async: server/store/sqlite_store.h
  std::string http;                        // host:port of the viewer and gRPC-Web; empty: none
  std::string admin;                       // host:port of /healthz, /readyz, /metrics; empty: none
  std::vector<std::string> allowed_hosts;  // names of --http besides loopback's and its own
  std::vector<std::string> cors_origins;   // sites whose pages may use --http
  HttpTimeouts http_timeouts;              // without flags
  std::string web_root;                    // folder of the viewer; empty: beside the executable
  std::string tls_cert, tls_key,
      tls_client_ca;       // PEM files; client_ca asks for client certificates
  std::string token_file;  // lines "sha256hex role name [tenant]"
  std::string jwks_file;   // keys of JSON web tokens: server/base/auth/jwt_verifier.h
  std::string jwt_issuer, jwt_audience;
  std::string quota_file;            // of tenants: server/base/quotas/quota_table.h
  std::string audit_log;             // who did what: server/base/audit_log.h; empty: not kept
  double caller_share = 0.75;        // the most of each limit that one caller may have
  bool trust_forwarded_for = false;  // the caller's address is in x-forwarded-for
  bool insecure = false;             // allow an open port without TLS or tokens
  bool reflection = false;           // answer gRPC reflection on an open port too
  std::string log_level = "info";    // trace, debug, info, warn, error, off
  std::string log_format = "text";   // text or json
  absl::Duration heartbeat_interval = absl::Milliseconds(600);
  absl::Duration first_message_timeout = absl::Seconds(30);  // of a stream that has begun
  absl::Duration write_timeout = absl::Seconds(60);          // for a client to take what is written
  absl::Duration drain_delay = absl::Seconds(2);  // NOT_SERVING to Shutdown: lets balancers notice
  absl::Duration drain_timeout = absl::Seconds(10);  // then running rpcs are cancelled
  absl::Duration scene_idle_ttl = absl::Hours(24);   // default of CreateScene.idle_ttl
  std::string encoder = "latticed";                  // writer of Draco streams
  std::string node;                                  // in logs and metadata; empty: the host name
};

// What the command line asks for: to run with `options`, or to print `text` and exit.
struct CommandLine {
  Options options;
  std::optional<std::string> text;  // of --help, --version, --print-config
};

// Reads flags, environment and file. kInvalidArgument with one sentence that names the option.
[[nodiscard]] absl::StatusOr<CommandLine> ParseCommandLine(int argc, const char* const* argv);
// "unix:PATH", a file whose permissions say who may connect.
[[nodiscard]] bool IsUnixSocket(std::string_view address);
// Whether only this machine can reach the address.
[[nodiscard]] bool IsLoopback(std::string_view listen);
// The most connections of --listen, and of --http: no more than the process may have open files.
[[nodiscard]] size_t MostConnections(const Options& options);
// Of these, the most of one address, which is at least 1. All, behind a proxy that is trusted.
[[nodiscard]] size_t MostOfAddress(const Options& options);
// Whether connections of this machine have shares as well: without tokens there is nobody to be fair to.
[[nodiscard]] bool CountsLoopback(const Options& options);
// Whether callers need tokens.
[[nodiscard]] bool NeedsTokens(const Options& options);
// Checks ranges, and combinations such as an open port without TLS or tokens.
[[nodiscard]] absl::Status Validate(const Options& options);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_OPTIONS_H_
