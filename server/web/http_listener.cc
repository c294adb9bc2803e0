// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/http_listener.h"

#include <boost/asio/dispatch.hpp>
#include <boost/asio/strand.hpp>
#include <chrono>
#include <string_view>
#include <utility>

#include "fmt/format.h"
#include "server/web/http_answers.h"
#include "server/web/http_connection.h"
#include "server/web/transport.h"

namespace latticed::web {
namespace {

using net::ip::tcp;

// While the process has no file descriptor left.
constexpr auto kAcceptRetry = std::chrono::milliseconds(100);

const HttpHandler kRefuse = [](const std::shared_ptr<HttpExchange>& exchange) {
  HttpResponse answer = TextAnswer(503, "this server has as many connections as fit");
  answer.fields.push_back({"retry-after", "1"});
  answer.fields.push_back({"connection", "close"});
  exchange->Reply(std::move(answer));
};

absl::Status Unreadable(std::string_view flag, const std::string& path, const error_code& failure) {
  return absl::InvalidArgumentError(
      fmt::format("{}: cannot use '{}': {}", flag, path, failure.message()));
}

}  // namespace

absl::StatusOr<std::unique_ptr<net::ssl::context>> MakeTlsContext(const Options& options) {
  if (options.tls_cert.empty()) return nullptr;
  auto tls = std::make_unique<net::ssl::context>(net::ssl::context::tls_server);
  error_code failure;
  tls->set_options(net::ssl::context::default_workarounds | net::ssl::context::no_sslv2 |
                   net::ssl::context::no_sslv3 | net::ssl::context::no_tlsv1 |
                   net::ssl::context::no_tlsv1_1 | net::ssl::context::no_compression);
  tls->use_certificate_chain_file(options.tls_cert, failure);
  if (failure) return Unreadable("--tls-cert", options.tls_cert, failure);
  tls->use_private_key_file(options.tls_key, net::ssl::context::pem, failure);
  if (failure) return Unreadable("--tls-key", options.tls_key, failure);
  if (!options.tls_client_ca.empty()) {
    tls->load_verify_file(options.tls_client_ca, failure);
    if (failure) return Unreadable("--tls-client-ca", options.tls_client_ca, failure);
    tls->set_verify_mode(net::ssl::verify_peer | net::ssl::verify_fail_if_no_peer_cert);
  }
  return tls;
}

HttpListener::HttpListener(net::io_context& context, net::ssl::context* tls,
                           ConnectionSet* connections, HttpTimeouts timeouts, HttpHandler handler)
    : context_(context),
      acceptor_(net::make_strand(context)),
      retry_(acceptor_.get_executor()),
      tls_(tls),
      connections_(connections),
      timeouts_(timeouts),
      handler_(std::move(handler)) {}

absl::StatusOr<std::shared_ptr<HttpListener>> HttpListener::Open(
    net::io_context& context, const std::string& flag, const std::string& listen,
    net::ssl::context* tls, ConnectionSet* connections, HttpTimeouts timeouts,
    HttpHandler handler) {
  const size_t colon = listen.rfind(':');
  if (colon == std::string::npos) {
    return absl::InvalidArgumentError(fmt::format("{}: '{}' is no host:port", flag, listen));
  }
  std::string host = listen.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  std::shared_ptr<HttpListener> listener(
      new HttpListener(context, tls, connections, timeouts, std::move(handler)));
  if (const absl::Status bound = listener->Bind(host, listen.substr(colon + 1)); !bound.ok()) {
    return absl::UnavailableError(
        fmt::format("{}: cannot serve on '{}': {}", flag, listen, std::string(bound.message())));
  }
  listener->address_ =
      fmt::format("{}:{}", listen.substr(0, colon), listener->acceptor_.local_endpoint().port());
  listener->Accept();
  return listener;
}

absl::Status HttpListener::Bind(const std::string& host, const std::string& port) {
  error_code failure;
  tcp::resolver resolver(context_);
  const auto found = resolver.resolve(host, port, tcp::resolver::passive, failure);
  if (failure) return absl::UnavailableError(failure.message());
  const tcp::endpoint endpoint = found.begin()->endpoint();
  acceptor_.open(endpoint.protocol(), failure);
  if (!failure) acceptor_.set_option(net::socket_base::reuse_address(true), failure);
  if (!failure) acceptor_.bind(endpoint, failure);
  if (!failure) acceptor_.listen(net::socket_base::max_listen_connections, failure);
  return failure ? absl::UnavailableError(failure.message()) : absl::OkStatus();
}

void HttpListener::Accept() {
  acceptor_.async_accept(net::make_strand(context_), [self = shared_from_this()](
                                                         error_code failure, tcp::socket socket) {
    if (failure == net::error::operation_aborted || !self->acceptor_.is_open()) return;
    if (!failure) {
      self->OnAccept(std::move(socket));
      return self->Accept();
    }
    self->retry_.expires_after(kAcceptRetry);
    self->retry_.async_wait([self](error_code) {
      if (self->acceptor_.is_open()) self->Accept();
    });
  });
}

void HttpListener::OnAccept(tcp::socket socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(net::socket_base::keep_alive(true), ignored);  // finds those that vanished
  auto place = connections_->Enter();
  if (place == nullptr) return;
  const bool served = place->served();
  HttpTimeouts timeouts = timeouts_;
  if (!served) timeouts.idle = timeouts.head;
  ServeConnection(Transport(std::move(socket), tls_), std::move(place), timeouts,
                  served ? handler_ : kRefuse);
}

void HttpListener::Close() {
  net::post(acceptor_.get_executor(), [self = shared_from_this()] {
    error_code ignored;
    self->acceptor_.close(ignored);
    self->retry_.cancel();
  });
}

}  // namespace latticed::web
