// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// HTTP of the server, on two ports.
//
//   --http    the viewer's files; POST /<service>/<method>: gRPC-Web; GET /ws/…: the WebSocket of
//             Deform; GET /export/<scene>.<format>. TLS and tokens as for gRPC; Host and Origin are
//             checked: server/web/request_guard.h
//   --admin   /healthz, /readyz, /metrics, without TLS or tokens, and nothing else
//
// Every rpc goes as bytes to the server's own channel. Only Deform and Export are named here, because they
// have forms of their own over HTTP.
//
// Memory   each connection holds at most one message in and one out. --transport-memory or
//          --max-connections limits the number of connections
// Threads  safe
#ifndef LATTICED_SERVER_WEB_WEB_SERVER_H_
#define LATTICED_SERVER_WEB_WEB_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/base/connection_counts.h"
#include "server/base/options.h"
#include "server/net/tls_context.h"
#include "server/web/admin_pages.h"
#include "server/web/generic_call.h"

namespace latticed::web {

class WebServer {
 public:
  // Serves options.http and options.admin, those that are not empty, when it returns.
  // kInvalidArgument for unreadable credentials, kUnavailable for a port that is taken.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<WebServer>> Start(const Options& options,
                                                                        ServerChannel server,
                                                                        AdminHooks admin);
  ~WebServer();

  // host:port with the port that was taken; empty where there is none.
  [[nodiscard]] std::string http_address() const;
  [[nodiscard]] std::string admin_address() const;

  // The connections of --http.
  [[nodiscard]] ConnectionCounts connections() const;

  // For new connections.
  void SetTls(TlsContextPtr context);
  // Takes no more connections or requests on --http, waits for running ones, and cancels the rest at
  // `deadline`. Called before gRPC's server ends, which would cancel them at once.
  void Drain(absl::Time deadline);
  // Cancels what runs, and ends both ports. Idempotent.
  void Stop();

 private:
  struct Impl;
  explicit WebServer(std::unique_ptr<Impl> impl);
  const std::unique_ptr<Impl> impl_;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_WEB_SERVER_H_
