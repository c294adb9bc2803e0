// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The port of gRPC. It accepts connections and hands them to gRPC, because gRPC 1.51's own listener does
// not limit their number, and stops accepting for good once the process has run out of file descriptors
// (CVE-2023-4785).
//
// gRPC does not say when a connection ends. It has ended when its descriptor is closed or is another socket,
// which the inode of the descriptor shows.
//
// Threads  safe
#ifndef LATTICED_SERVER_EDGE_GRPC_LISTENER_H_
#define LATTICED_SERVER_EDGE_GRPC_LISTENER_H_

#include <grpcpp/server_builder.h>

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/base/connection_counts.h"
#include "server/base/options.h"
#include "server/net/tcp_listener.h"

namespace latticed {

class GrpcListener {
 public:
  using Acceptor = grpc::experimental::ExternalConnectionAcceptor;

  // Accepts on options.listen for the server of `acceptor`, which has started. Closes connections above the
  // limit; their clients see UNAVAILABLE. kUnavailable, kInvalidArgument.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<GrpcListener>> Open(
      const Options& options, std::unique_ptr<Acceptor> acceptor);
  ~GrpcListener() { Close(); }

  const std::string& address() const { return listener_->address(); }
  [[nodiscard]] ConnectionCounts counts() ABSL_LOCKS_EXCLUDED(mutex_);
  // Hands over no connection afterwards. Called before the server ends. Idempotent.
  void Close();

 private:
  GrpcListener(const Options& options, std::unique_ptr<Acceptor> acceptor);
  void Take(const std::string& address, int socket) ABSL_LOCKS_EXCLUDED(mutex_);
  // Counts the connection. Returns false when there are too many, in all or of its address.
  bool Enter(const std::string& address, int socket) ABSL_LOCKS_EXCLUDED(mutex_);
  // Connections of an empty address are not counted.
  bool HasShare(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void DropEnded() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  struct Socket {
    uint64_t inode;
    std::string address;
  };
  const size_t most_, most_of_address_;
  const bool counts_loopback_;
  const std::unique_ptr<Acceptor> acceptor_;

  Mutex mutex_;
  std::map<int, Socket> sockets_ ABSL_GUARDED_BY(mutex_);  // by descriptor
  uint64_t refused_ ABSL_GUARDED_BY(mutex_) = 0;
  bool full_ ABSL_GUARDED_BY(mutex_) = false;  // the limit was reached, and logged

  boost::asio::io_context context_;
  std::shared_ptr<TcpListener> listener_;
  std::once_flag closed_;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_GRPC_LISTENER_H_
