// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The whole server as one object: everything that `latticed` runs, over a real gRPC channel. The
// daemon, `latticectl` without --server, and the tests start it alike.
//
//   auto server = InProcessServer::Start({.backend = "cpu"});
//   auto stub = v1::MeshService::NewStub((*server)->channel());
//
// Threads  safe
#ifndef LATTICED_SERVER_IN_PROCESS_H_
#define LATTICED_SERVER_IN_PROCESS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/base/options.h"
#include "server/base/watchdog.h"

namespace grpc {
class Channel;
}

namespace latticed {

class Backend;
class GrpcServer;
class Store;
struct ServerEnv;
namespace web {
class WebServer;
}

class InProcessServer {
 public:
  // Serves on a free port of 127.0.0.1, whatever options.listen says, and configures the process's log.
  // kInvalidArgument for invalid options, kUnimplemented or kUnavailable for a backend or port that cannot
  // be used.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<InProcessServer>> Start(Options options);
  // The same on these backends, whatever options.backend says; the first one serves. Meshes and scenes are kept in
  // `store` and come from it, whatever options.data_dir says, if it is not null.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<InProcessServer>> Start(
      Options options, std::vector<std::unique_ptr<Backend>> backends,
      std::shared_ptr<Store> store = nullptr);
  // As the first on options.listen.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<InProcessServer>> Serve(Options options);
  ~InProcessServer();

  // A new channel without TLS.
  [[nodiscard]] std::shared_ptr<grpc::Channel> channel() const;
  [[nodiscard]] std::string address() const;
  // The addresses of --http and --admin, host:port; empty when there is none.
  [[nodiscard]] std::string http_address() const;
  [[nodiscard]] std::string admin_address() const;
  // "cpu: AVX-512, 2 threads, …": what evaluates.
  [[nodiscard]] std::string backend_description() const;

  // Reads tokens, their keys and the certificates again, and takes the log level of `options`. Calls and
  // connections go on. kInvalidArgument for a file that cannot be used; what it would change stays.
  [[nodiscard]] absl::Status Reload(const Options& options);
  // What shows that the server moves: server/base/watchdog.h.
  [[nodiscard]] Pulse TakePulse() const;

  // What GET /metrics of the admin listener answers.
  [[nodiscard]] std::string metrics() const;

  // Ends the server so that balancers notice: health says NOT_SERVING; options.drain_delay passes; streams
  // get goaway, new calls are refused, and running calls have options.drain_timeout to end. Then Stop. Where others share the
  // store, it hands its scenes over at once.
  void Drain();
  // Cancels running calls and returns when all are done. Idempotent.
  void Stop();

 private:
  InProcessServer();
  void HandOver();
  // Without `backends` it makes those of options.backend.
  static absl::StatusOr<std::unique_ptr<InProcessServer>> ServeOn(
      Options options, std::vector<std::unique_ptr<Backend>> backends,
      std::shared_ptr<Store> store);
  absl::Status StartWeb();

  std::unique_ptr<ServerEnv> env_;
  std::unique_ptr<GrpcServer> server_;   // uses env_
  std::unique_ptr<web::WebServer> web_;  // last: calls server_; null without --http and --admin
};

}  // namespace latticed

#endif  // LATTICED_SERVER_IN_PROCESS_H_
