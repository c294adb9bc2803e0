// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A listening port with a thread of its own, for a server that asks for sockets and not for HTTP.
//
// Threads  safe
#ifndef LATTICED_SERVER_EDGE_SOCKET_LISTENER_H_
#define LATTICED_SERVER_EDGE_SOCKET_LISTENER_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace latticed {

class SocketListener {
 public:
  // Called one after the other with a connected socket, which does not block and belongs to the
  // function.
  using OnSocket = std::function<void(int socket)>;

  // TcpListener::Open's errors.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<SocketListener>> Open(
      const std::string& flag, const std::string& listen, OnSocket on_socket);
  ~SocketListener();

  [[nodiscard]] const std::string& address() const;  // with the port that was taken
  // No socket is taken after it.
  void Close();

 private:
  struct Impl;
  explicit SocketListener(std::unique_ptr<Impl> impl);
  const std::unique_ptr<Impl> impl_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_SOCKET_LISTENER_H_
