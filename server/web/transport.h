// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A TCP connection with or without TLS, as one stream type, so that the HTTP library is compiled once. Only
// the files that use that library include it: http_connection.cc, deform_socket.cc, web_server.cc.
//
// Threads  on the strand that is its executor
#ifndef LATTICED_SERVER_WEB_TRANSPORT_H_
#define LATTICED_SERVER_WEB_TRANSPORT_H_

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

namespace net = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;

class Transport {
 public:
  using Socket = net::ip::tcp::socket;
  using executor_type = Socket::executor_type;  // the names that the library asks for

  // With `tls`, the handshake comes first; the context outlives the connection.
  Transport(Socket socket, net::ssl::context* tls) {
    if (tls == nullptr) {
      plain_ = std::make_unique<Socket>(std::move(socket));
    } else {
      tls_ = std::make_unique<net::ssl::stream<Socket>>(std::move(socket), *tls);
    }
  }

  bool secure() const { return tls_ != nullptr; }
  Socket& socket() { return tls_ != nullptr ? tls_->next_layer() : *plain_; }
  executor_type get_executor() { return socket().get_executor(); }
  // The client's address as gRPC writes it, "ipv4:127.0.0.1:5000", "ipv6:%5B::1%5D:5000"; empty once
  // it has gone.
  std::string peer() {
    error_code gone;
    const net::ip::tcp::endpoint end = socket().remote_endpoint(gone);
    if (gone) return "";
    net::ip::address address = end.address();
    if (address.is_v6() && address.to_v6().is_v4_mapped()) {
      address = net::ip::make_address_v4(net::ip::v4_mapped, address.to_v6());
    }
    if (address.is_v4()) return fmt::format("ipv4:{}:{}", address.to_string(), end.port());
    return fmt::format("ipv6:%5B{}%5D:{}", address.to_string(), end.port());
  }

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (tls_ != nullptr) {
      tls_->async_read_some(buffers, std::forward<Handler>(handler));
    } else {
      plain_->async_read_some(buffers, std::forward<Handler>(handler));
    }
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (tls_ != nullptr) {
      tls_->async_write_some(buffers, std::forward<Handler>(handler));
    } else {
      plain_->async_write_some(buffers, std::forward<Handler>(handler));
    }
  }
  // Only with TLS.
  template <typename Handler>
  void Handshake(Handler&& handler) {
    tls_->async_handshake(net::ssl::stream_base::server, std::forward<Handler>(handler));
  }
  // Says that nothing more will be sent.
  template <typename Handler>
  void Shutdown(Handler&& handler) {
    if (tls_ != nullptr) return tls_->async_shutdown(std::forward<Handler>(handler));
    error_code failure;
    plain_->shutdown(Socket::shutdown_send, failure);
    net::post(get_executor(), beast::bind_handler(std::forward<Handler>(handler), failure));
  }
  // Closes at once; operations under way fail.
  void Close() {
    error_code ignored;
    socket().close(ignored);
  }

 private:
  std::unique_ptr<Socket> plain_;
  std::unique_ptr<net::ssl::stream<Socket>> tls_;
};

// For the library to send; `bytes` outlive the write.
inline std::vector<net::const_buffer> BuffersOf(const OutBytes& bytes) {
  std::vector<net::const_buffer> buffers;
  for (const grpc::Slice& slice : bytes) buffers.emplace_back(slice.begin(), slice.size());
  return buffers;
}

// How a WebSocket ends its connection: the names that the library asks for.
template <typename Handler>
void async_teardown(beast::role_type /*role*/, Transport& transport, Handler&& handler) {
  transport.Shutdown(std::forward<Handler>(handler));
}
inline void teardown(beast::role_type /*role*/, Transport& transport, error_code& /*failure*/) {
  transport.Close();
}
inline void beast_close_socket(Transport& transport) { transport.Close(); }

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_TRANSPORT_H_
