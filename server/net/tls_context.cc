// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/net/tls_context.h"

#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <boost/asio/buffer.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/read_file.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

namespace ssl = boost::asio::ssl;
using Failure = boost::system::error_code;

// Reads the file and gives it to `use`, which parses it.
template <typename Use>
absl::StatusOr<std::string> Read(std::string_view option, const std::string& path, const Use& use) {
  const auto unusable = [&](const std::string& why) {
    return absl::InvalidArgumentError(fmt::format("{}: {}", option, why));
  };
  auto pem = ReadFile(path);
  if (!pem.ok()) return unusable(std::string(pem.status().message()));
  Failure failure;
  use(boost::asio::buffer(*pem), failure);
  if (failure) return unusable(fmt::format("cannot use '{}': {}", path, failure.message()));
  return pem;
}

// The private key of the context, decrypted, without what else its file holds.
std::string PrivateKeyOf(ssl::context& context) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> out(BIO_new(BIO_s_mem()), BIO_free);
  PEM_write_bio_PrivateKey(out.get(), SSL_CTX_get0_privatekey(context.native_handle()), nullptr,
                           nullptr, 0, nullptr, nullptr);
  char* bytes = nullptr;
  const auto size = BIO_get_mem_data(out.get(), &bytes);
  return std::string(bytes, static_cast<size_t>(size));
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
  LATTICED_ASSIGN_OR_RETURN(tls->certificate, Read("--tls-cert", options.tls_cert,
                                                   [&](const auto& pem, Failure& failure) {
                                                     context.use_certificate_chain(pem, failure);
                                                   }));
  const auto use_key = [&](const auto& pem, Failure& failure) {
    context.use_private_key(pem, ssl::context::pem, failure);
  };
  LATTICED_RETURN_IF_ERROR(Read("--tls-key", options.tls_key, use_key).status());
  if (SSL_CTX_check_private_key(context.native_handle()) != 1) {
    return absl::InvalidArgumentError(
        fmt::format("--tls-key: '{}' is not the key of '{}'", options.tls_key, options.tls_cert));
  }
  tls->key = PrivateKeyOf(context);
  if (!options.tls_client_ca.empty()) {
    LATTICED_ASSIGN_OR_RETURN(
        tls->client_ca,
        Read("--tls-client-ca", options.tls_client_ca, [&](const auto& pem, Failure& failure) {
          context.add_certificate_authority(pem, failure);
        }));
    context.set_verify_mode(ssl::verify_peer | ssl::verify_fail_if_no_peer_cert);
  }
  return tls;
}

}  // namespace latticed
