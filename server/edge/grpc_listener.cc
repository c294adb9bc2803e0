// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/grpc_listener.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"

namespace latticed {
namespace {

// The inode number of the descriptor's socket, which no other open socket has. 0 if it is no socket.
uint64_t SocketInode(int descriptor) {
  struct stat state = {};
  return fstat(descriptor, &state) == 0 && S_ISSOCK(state.st_mode) ? state.st_ino : 0;
}

}  // namespace

GrpcListener::GrpcListener(const Options& options, std::unique_ptr<Acceptor> acceptor)
    : most_(MostConnections(options)),
      most_of_address_(MostOfAddress(options)),
      counts_loopback_(CountsLoopback(options)),
      acceptor_(std::move(acceptor)) {}

absl::StatusOr<std::unique_ptr<GrpcListener>> GrpcListener::Open(
    const Options& options, std::unique_ptr<Acceptor> acceptor) {
  std::unique_ptr<GrpcListener> result(new GrpcListener(options, std::move(acceptor)));
  LATTICED_ASSIGN_OR_RETURN(
      result->listener_,
      TcpListener::Open(result->context_, "--listen", options.listen,
                        [listener = result.get()](boost::asio::ip::tcp::socket socket) {
                          socket.native_non_blocking(true);
                          const std::string address =
                              CountedAddress(socket, listener->counts_loopback_);
                          listener->Take(address, socket.release());
                        }));
  result->thread_ = std::thread([&context = result->context_] { RunUntilDone(context); });
  return result;
}

void GrpcListener::Close() {
  if (listener_ == nullptr) return;  // the port could not be opened
  std::call_once(closed_, [this] {
    listener_->Close();
    thread_.join();  // ends, because its context has no more work
  });
}

ConnectionCounts GrpcListener::counts() {
  const MutexLock lock(&mutex_);
  DropEnded();
  return {.open = sockets_.size(), .most = most_, .refused = refused_};
}

void GrpcListener::DropEnded() {
  std::erase_if(sockets_,
                [](const auto& entry) { return SocketInode(entry.first) != entry.second.inode; });
}

bool GrpcListener::HasShare(const std::string& address) {
  if (address.empty()) return true;
  const auto of_address =
      std::ranges::count(sockets_, address, [](const auto& entry) { return entry.second.address; });
  return static_cast<size_t>(of_address) < most_of_address_;
}

bool GrpcListener::Enter(const std::string& address, int socket) {
  const MutexLock lock(&mutex_);
  sockets_.erase(socket);  // the connection that had this descriptor has ended
  if (sockets_.size() >= most_ || !HasShare(address)) DropEnded();
  if (!HasShare(address)) {
    ++refused_;
    return false;
  }
  if (sockets_.size() >= most_) {
    ++refused_;
    if (!std::exchange(full_, true)) {
      LogEvent(spdlog::level::warn, "connections are refused: their limit is reached",
               {{"connections", fmt::to_string(most_)}});
    }
    return false;
  }
  full_ = false;
  sockets_[socket] = {SocketInode(socket), address};
  return true;
}

void GrpcListener::Take(const std::string& address, int socket) {
  if (!Enter(address, socket)) {
    // No GOAWAY is sent: after one, clients would connect again at once.
    close(socket);
    return;
  }
  // Set as gRPC's own listener does: the connection ends when sent bytes are not acknowledged in this time.
  const int patience_ms = limits::kKeepaliveTimeoutMs;
  setsockopt(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, sizeof(patience_ms));
  Acceptor::NewConnectionParameters connection;
  connection.fd = socket;
  acceptor_->HandleNewConnection(&connection);
}

}  // namespace latticed
