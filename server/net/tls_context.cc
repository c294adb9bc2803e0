// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/net/tls_context.h"

#include <openssl/ssl.h>

#include <boost/asio/buffer.hpp>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

namespace ssl = boost::asio::ssl;
using Failure = boost::system::error_code;

absl::Status Unusable(std::string_view flag, const std::string& path, std::string_view why) {
  return absl::InvalidArgumentError(fmt::format("{}: cannot use '{}': {}", flag, path, why));
}

// Reads the file into `content`, and gives it to `use`.
template <typename Use>
absl::Status Read(std::string_view flag, const std::string& path, std::string& content,
                  const Use& use) {
  std::ifstream file(path, std::ios::binary);
  content.assign(std::istreambuf_iterator<char>(file), {});
  if (!file) return Unusable(flag, path, "it cannot be read");
  Failure failure;
  use(boost::asio::buffer(content), failure);
  return failure ? Unusable(flag, path, failure.message()) : absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Tls>> ReadTls(const Options& options) {
  if (options.tls_cert.empty()) return nullptr;
  auto tls = std::make_shared<Tls>();
  tls->context = std::make_shared<ssl::context>(ssl::context::tls_server);
  ssl::context& context = *tls->context;
  context.set_options(ssl::context::default_workarounds | ssl::context::no_sslv2 |
                      ssl::context::no_sslv3 | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1 |
                      ssl::context::no_compression);
  LATTICED_RETURN_IF_ERROR(Read(
      "--tls-cert", options.tls_cert, tls->certificate,
      [&](const auto& pem, Failure& failure) { context.use_certificate_chain(pem, failure); }));
  LATTICED_RETURN_IF_ERROR(
      Read("--tls-key", options.tls_key, tls->key, [&](const auto& pem, Failure& failure) {
        context.use_private_key(pem, ssl::context::pem, failure);
      }));
  if (SSL_CTX_check_private_key(context.native_handle()) != 1) {
    return absl::InvalidArgumentError(
        fmt::format("--tls-key: '{}' is not the key of '{}'", options.tls_key, options.tls_cert));
  }
  if (!options.tls_client_ca.empty()) {
    LATTICED_RETURN_IF_ERROR(Read("--tls-client-ca", options.tls_client_ca, tls->client_ca,
                                  [&](const auto& pem, Failure& failure) {
                                    context.add_certificate_authority(pem, failure);
                                  }));
    context.set_verify_mode(ssl::verify_peer | ssl::verify_fail_if_no_peer_cert);
  }
  return tls;
}

}  // namespace latticed
