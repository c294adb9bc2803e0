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
#include "server/rpc/server_env.h"

namespace latticed {

class GrpcServer {
 public:
  // Serves when it returns. kInvalidArgument for unreadable credentials, kUnavailable for a port
  // that cannot be had. `env` outlives the result.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<GrpcServer>> Start(ServerEnv* env);
  ~GrpcServer();

  [[nodiscard]] std::string address() const;  // with the port that was taken
  // Of --listen; none are counted on a Unix socket.
  [[nodiscard]] ConnectionCounts connections() const;
  // Calls from this process, without a socket.
  [[nodiscard]] std::shared_ptr<grpc::Channel> InProcessChannel();
  void SetServing(bool serving);
  // What health says.
  bool serving() const { return serving_; }
  // Takes no more calls, waits for those running, and cancels what is left at `deadline`. Returns
  // when all are done. Idempotent.
  void Shutdown(absl::Time deadline);

 private:
  explicit GrpcServer(ServerEnv* env);
  void OnDeviceLost(const absl::Status& why);

  ServerEnv* const env_;
  std::atomic<bool> serving_ = false;
  std::vector<std::unique_ptr<grpc::Service>> services_;
  std::unique_ptr<grpc::Server> server_;    // uses the services
  std::unique_ptr<GrpcListener> listener_;  // last: hands connections to the server
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_GRPC_SERVER_H_
