// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/net/tls_context.h"

#include <openssl/ssl.h>

#include <string>
#include <string_view>
#include <utility>

#include "fmt/format.h"

namespace latticed {
namespace {

namespace ssl = boost::asio::ssl;

absl::Status Unreadable(std::string_view flag, const std::string& path,
                        const boost::system::error_code& failure) {
  return absl::InvalidArgumentError(
      fmt::format("{}: cannot use '{}': {}", flag, path, failure.message()));
}

}  // namespace

absl::StatusOr<TlsContextPtr> MakeTlsContext(const Options& options) {
  if (options.tls_cert.empty()) return nullptr;
  auto tls = std::make_shared<ssl::context>(ssl::context::tls_server);
  boost::system::error_code failure;
  tls->set_options(ssl::context::default_workarounds | ssl::context::no_sslv2 |
                   ssl::context::no_sslv3 | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1 |
                   ssl::context::no_compression);
  tls->use_certificate_chain_file(options.tls_cert, failure);
  if (failure) return Unreadable("--tls-cert", options.tls_cert, failure);
  tls->use_private_key_file(options.tls_key, ssl::context::pem, failure);
  if (failure) return Unreadable("--tls-key", options.tls_key, failure);
  if (SSL_CTX_check_private_key(tls->native_handle()) != 1) {
    return absl::InvalidArgumentError(
        fmt::format("--tls-key: '{}' is not the key of '{}'", options.tls_key, options.tls_cert));
  }
  if (!options.tls_client_ca.empty()) {
    tls->load_verify_file(options.tls_client_ca, failure);
    if (failure) return Unreadable("--tls-client-ca", options.tls_client_ca, failure);
    tls->set_verify_mode(ssl::verify_peer | ssl::verify_fail_if_no_peer_cert);
  }
  return tls;
}

}  // namespace latticed
