// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The gRPC side of the server: port, credentials, services, health, reflection.
//
// Health knows "" and the full name of every service of latticed.v1. When the device is lost all of
// them are NOT_SERVING, for good.
// Threads  safe
#ifndef LATTICED_SERVER_EDGE_GRPC_SERVER_H_
#define LATTICED_SERVER_EDGE_GRPC_SERVER_H_

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/edge/grpc_listener.h"
#include "server/net/memory_file.h"
#include "server/rpc/server_env.h"

namespace latticed {

struct Tls;  // server/net/tls_context.h

class GrpcServer {
 public:
  // The server accepts calls when this returns. kInvalidArgument for unreadable credentials, kUnavailable
  // for a port that cannot be opened. `env` outlives the result.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<GrpcServer>> Start(ServerEnv* env);
  ~GrpcServer();

  [[nodiscard]] std::string address() const;  // with the port that was taken
  // The connections of --listen; those of a Unix socket are not counted.
  [[nodiscard]] ConnectionCounts connections() const;
  // A channel for calls from this process, without a socket.
  [[nodiscard]] std::shared_ptr<grpc::Channel> InProcessChannel();
  // Within a second, new connections use these certificates. kUnavailable if the system gives no memory for them.
  [[nodiscard]] absl::Status SetTls(const Tls& tls);
  // Sets what the health service answers.
  void SetServing(bool serving);
  bool serving() const { return serving_; }
  // Takes no more calls, waits for those running, and cancels what is left at `deadline`. Returns
  // when all are done. Idempotent.
  void Shutdown(absl::Time deadline);

 private:
  explicit GrpcServer(ServerEnv* env);
  void OnDeviceLost(const absl::Status& why);

  ServerEnv* const env_;
  std::atomic<bool> serving_ = false;
  MemoryFile identity_, client_ca_;  // gRPC reads them
  std::vector<std::unique_ptr<grpc::Service>> services_;
  std::unique_ptr<grpc::Server> server_;    // uses the services
  std::unique_ptr<GrpcListener> listener_;  // last: hands connections to the server
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_GRPC_SERVER_H_
