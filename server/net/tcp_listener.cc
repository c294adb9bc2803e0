// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/net/tcp_listener.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>
#include <exception>
#include <utility>

#include "fmt/format.h"
#include "server/base/address.h"
#include "server/base/telemetry.h"

namespace latticed {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::ip::tcp;

// The pause after a failed accept, mostly because the process has no file descriptor left.
constexpr auto kAcceptRetry = std::chrono::milliseconds(100);

error_code Listen(tcp::acceptor& acceptor, const tcp::endpoint& endpoint) {
  error_code failure;
  acceptor.open(endpoint.protocol(), failure);
  if (!failure) acceptor.set_option(net::socket_base::reuse_address(true), failure);
  if (!failure) acceptor.bind(endpoint, failure);
  if (!failure) acceptor.listen(net::socket_base::max_listen_connections, failure);
  return failure;
}

}  // namespace

void RunUntilDone(net::io_context& context) {
  for (;;) {
    try {
      context.run();
      return;
    } catch (const std::exception& failure) {
      LogEvent(spdlog::level::err, "a connection failed", {{"error", failure.what()}});
    }
  }
}

TcpListener::TcpListener(net::io_context& context, OnSocket on_socket)
    : context_(context), strand_(net::make_strand(context)), on_socket_(std::move(on_socket)) {}

absl::StatusOr<std::shared_ptr<TcpListener>> TcpListener::Open(net::io_context& context,
                                                               const std::string& flag,
                                                               const std::string& listen,
                                                               OnSocket on_socket) {
  const size_t colon = listen.rfind(':');
  if (colon == std::string::npos) {
    return absl::InvalidArgumentError(fmt::format("{}: '{}' is not host:port", flag, listen));
  }
  std::string host = listen.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  std::shared_ptr<TcpListener> listener(new TcpListener(context, std::move(on_socket)));
  if (const absl::Status bound = listener->Bind(host, listen.substr(colon + 1)); !bound.ok()) {
    return absl::UnavailableError(
        fmt::format("{}: cannot serve on '{}': {}", flag, listen, std::string(bound.message())));
  }
  listener->address_ = fmt::format("{}:{}", listen.substr(0, colon),
                                   listener->ports_.front().acceptor.local_endpoint().port());
  for (Port& port : listener->ports_) listener->Accept(port);
  return listener;
}

absl::Status TcpListener::Bind(const std::string& host, const std::string& port) {
  error_code failure;
  tcp::resolver resolver(context_);
  const auto found = resolver.resolve(host, port, tcp::resolver::passive, failure);
  if (failure) return absl::UnavailableError(failure.message());
  for (const auto& entry : found) {
    tcp::endpoint endpoint = entry.endpoint();
    // All addresses use the port that the first one got.
    if (!ports_.empty()) endpoint.port(ports_.front().acceptor.local_endpoint().port());
    const bool has_it = std::ranges::any_of(ports_, [&endpoint](const Port& other) {
      return other.acceptor.local_endpoint() == endpoint;
    });
    if (has_it) continue;  // the hosts file may have an address twice
    ports_.emplace_back(*this);
    const error_code refused = Listen(ports_.back().acceptor, endpoint);
    if (!refused) continue;
    ports_.pop_back();
    failure = refused;
    if (refused == net::error::address_in_use) return absl::UnavailableError(refused.message());
  }
  // One open address is enough: a name may have an address of a protocol that this machine lacks.
  return ports_.empty() ? absl::UnavailableError(failure.message()) : absl::OkStatus();
}

std::string CountedAddress(const tcp::socket& socket, bool counts_loopback) {
  error_code gone;
  const net::ip::address address = socket.remote_endpoint(gone).address();
  return counts_loopback || !address.is_loopback() ? NetworkOf(address.to_string()) : "";
}

void TcpListener::Accept(Port& port) {
  port.acceptor.async_accept(
      net::make_strand(context_),
      [self = shared_from_this(), &port](error_code failure, tcp::socket socket) {
        if (failure == net::error::operation_aborted || !port.acceptor.is_open()) return;
        if (!failure) {
          self->Accept(port);  // first, because on_socket_ may throw
          error_code ignored;
          socket.set_option(tcp::no_delay(true), ignored);
          return self->on_socket_(std::move(socket));
        }
        port.retry.expires_after(kAcceptRetry);
        port.retry.async_wait([self, &port](error_code) {
          if (port.acceptor.is_open()) self->Accept(port);
        });
      });
}

void TcpListener::Close() {
  net::post(strand_, [self = shared_from_this()] {
    for (Port& port : self->ports_) {
      error_code ignored;
      port.acceptor.close(ignored);
      port.retry.cancel();
    }
  });
}

}  // namespace latticed
