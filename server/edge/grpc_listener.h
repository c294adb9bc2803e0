// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The port of gRPC. Its connections are accepted here and handed over, since gRPC's own listener
// (1.51) knows no most of them, and accepts nothing ever again once the process has had no file
// descriptor for one (CVE-2023-4785).
//
// gRPC does not tell when a connection ends. One lives as long as its descriptor is the same socket.
//
// Threads  safe
#ifndef LATTICED_SERVER_EDGE_GRPC_LISTENER_H_
#define LATTICED_SERVER_EDGE_GRPC_LISTENER_H_

#include <grpcpp/server_builder.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/base/connection_counts.h"
#include "server/base/options.h"
#include "server/edge/call_guard.h"
#include "server/net/socket_listener.h"

namespace latticed {

class GrpcListener {
 public:
  using Acceptor = grpc::experimental::ExternalConnectionAcceptor;

  // Accepts on options.listen for the server that `acceptor` is of, which has started. A connection
  // too many is closed, which its client knows as UNAVAILABLE. kUnavailable, kInvalidArgument.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<GrpcListener>> Open(
      const Options& options, std::unique_ptr<Acceptor> acceptor);

  const std::string& address() const { return listener_->address(); }
  [[nodiscard]] ConnectionCounts counts() ABSL_LOCKS_EXCLUDED(mutex_);
  // Hands over nothing after it. Before the end of the server.
  void Close() { listener_->Close(); }

 private:
  GrpcListener(const Options& options, std::unique_ptr<Acceptor> acceptor);
  void Take(int socket) ABSL_LOCKS_EXCLUDED(mutex_);
  // Whether there is room for it; then it counts.
  bool Enter(int socket) ABSL_LOCKS_EXCLUDED(mutex_);
  void DropEnded() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Some may have ended.
  [[nodiscard]] CallGuard::Sockets sockets() ABSL_LOCKS_EXCLUDED(mutex_);

  const size_t most_;
  const std::unique_ptr<Acceptor> acceptor_;

  Mutex mutex_;
  std::map<int, uint64_t> sockets_ ABSL_GUARDED_BY(mutex_);  // their inodes, by descriptor
  uint64_t refused_ ABSL_GUARDED_BY(mutex_) = 0;
  bool full_ ABSL_GUARDED_BY(mutex_) = false;  // and that was logged

  // Last: their threads use the rest.
  CallGuard guard_;
  std::unique_ptr<SocketListener> listener_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_GRPC_LISTENER_H_
