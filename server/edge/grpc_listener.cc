// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/grpc_listener.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"

namespace latticed {

GrpcListener::GrpcListener(const Options& options, std::unique_ptr<Acceptor> acceptor)
    : most_(MostConnections(options)),
      acceptor_(std::move(acceptor)),
      guard_([this] { return sockets(); }) {}

absl::StatusOr<std::unique_ptr<GrpcListener>> GrpcListener::Open(
    const Options& options, std::unique_ptr<Acceptor> acceptor) {
  std::unique_ptr<GrpcListener> result(new GrpcListener(options, std::move(acceptor)));
  LATTICED_ASSIGN_OR_RETURN(
      auto listener,
      SocketListener::Open("--listen", options.listen,
                           [listener = result.get()](int socket) { listener->Take(socket); }));
  result->listener_ = std::move(listener);
  return result;
}

ConnectionCounts GrpcListener::counts() {
  const MutexLock lock(&mutex_);
  DropEnded();
  return {.open = sockets_.size(), .most = most_, .refused = refused_, .cut = guard_.cut()};
}

CallGuard::Sockets GrpcListener::sockets() {
  const MutexLock lock(&mutex_);
  return {sockets_.begin(), sockets_.end()};
}

void GrpcListener::DropEnded() {
  std::erase_if(sockets_,
                [](const auto& entry) { return SocketInode(entry.first) != entry.second; });
}

bool GrpcListener::Enter(int socket) {
  const MutexLock lock(&mutex_);
  sockets_.erase(socket);  // what had the descriptor has ended
  if (sockets_.size() >= most_) DropEnded();
  if (sockets_.size() >= most_) {
    ++refused_;
    if (!std::exchange(full_, true)) {
      LogEvent(spdlog::level::warn, "connections are refused, there are as many as may be",
               {{"connections", fmt::to_string(most_)}});
    }
    return false;
  }
  full_ = false;
  sockets_[socket] = SocketInode(socket);
  return true;
}

void GrpcListener::Take(int socket) {
  if (!Enter(socket)) {
    // Without a word: after the GOAWAY of a server that works, clients connect anew at once, and again.
    close(socket);
    return;
  }
  // As gRPC's own listener sets it: what is sent to a client that vanished fails by then.
  const int patience_ms = limits::kKeepaliveTimeoutMs;
  setsockopt(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, sizeof(patience_ms));
  Acceptor::NewConnectionParameters connection;
  connection.fd = socket;
  acceptor_->HandleNewConnection(&connection);
}

}  // namespace latticed
