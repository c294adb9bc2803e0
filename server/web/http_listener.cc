// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/http_listener.h"

#include <utility>

#include "fmt/format.h"
#include "server/web/http_answers.h"
#include "server/web/http_connection.h"
#include "server/web/transport.h"

namespace latticed::web {
namespace {

using net::ip::tcp;

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

absl::StatusOr<std::shared_ptr<TcpListener>> ListenForHttp(
    net::io_context& context, const std::string& flag, const std::string& listen,
    net::ssl::context* tls, ConnectionSet* connections, const HttpTimeouts& timeouts,
    const HttpHandler& handler) {
  return TcpListener::Open(context, flag, listen, [=](tcp::socket socket) {
    error_code ignored;
    socket.set_option(net::socket_base::keep_alive(true), ignored);  // finds those that vanished
    auto place = connections->Enter();
    if (place == nullptr) return;
    const bool served = place->served();
    HttpTimeouts patience = timeouts;
    if (!served) patience.idle = patience.head;
    ServeConnection(Transport(std::move(socket), tls), std::move(place), patience,
                    served ? handler : kRefuse);
  });
}

}  // namespace latticed::web
