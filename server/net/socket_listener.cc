// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/net/socket_listener.h"

#include <boost/asio/io_context.hpp>
#include <mutex>
#include <thread>
#include <utility>

#include "core/base/status_macros.h"
#include "server/net/tcp_listener.h"

namespace latticed {

struct SocketListener::Impl {
  boost::asio::io_context context;
  std::shared_ptr<TcpListener> listener;
  std::once_flag closed;
  std::thread thread;
};

SocketListener::SocketListener(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

SocketListener::~SocketListener() { Close(); }

absl::StatusOr<std::unique_ptr<SocketListener>> SocketListener::Open(const std::string& flag,
                                                                     const std::string& listen,
                                                                     OnSocket on_socket) {
  auto impl = std::make_unique<Impl>();
  LATTICED_ASSIGN_OR_RETURN(
      auto listener,
      TcpListener::Open(impl->context, flag, listen,
                        [on_socket = std::move(on_socket)](boost::asio::ip::tcp::socket socket) {
                          socket.native_non_blocking(true);
                          on_socket(socket.release());
                        }));
  impl->listener = std::move(listener);
  impl->thread = std::thread([&context = impl->context] { RunUntilDone(context); });
  return std::unique_ptr<SocketListener>(new SocketListener(std::move(impl)));
}

const std::string& SocketListener::address() const { return impl_->listener->address(); }

void SocketListener::Close() {
  std::call_once(impl_->closed, [this] {
    impl_->listener->Close();
    impl_->thread.join();  // nothing is left to wait for
  });
}

}  // namespace latticed
