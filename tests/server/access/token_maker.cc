// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/access/token_maker.h"

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ecdsa.h>
#include <openssl/hmac.h>
#include <openssl/rsa.h>

#include <algorithm>
#include <utility>

#include "absl/strings/escaping.h"

namespace latticed::testing {
namespace {

constexpr int kCoordinateBytes = 32;  // of P-256

std::string Number(const EVP_PKEY* key, const char* name, int least_bytes = 0) {
  BIGNUM* number = nullptr;
  EVP_PKEY_get_bn_param(key, name, &number);
  std::string bytes(static_cast<size_t>(std::max(BN_num_bytes(number), least_bytes)), '\0');
  BN_bn2binpad(number, reinterpret_cast<uint8_t*>(bytes.data()), static_cast<int>(bytes.size()));
  BN_free(number);
  return Base64Url(bytes);
}

// r and s of a signature in DER, each in 32 bytes (RFC 7518, 3.4).
std::string RawSignature(const std::string& der) {
  const auto* at = reinterpret_cast<const uint8_t*>(der.data());
  ECDSA_SIG* signature = d2i_ECDSA_SIG(nullptr, &at, static_cast<long>(der.size()));
  std::string raw(2 * kCoordinateBytes, '\0');
  auto* out = reinterpret_cast<uint8_t*>(raw.data());
  BN_bn2binpad(ECDSA_SIG_get0_r(signature), out, kCoordinateBytes);
  BN_bn2binpad(ECDSA_SIG_get0_s(signature), out + kCoordinateBytes, kCoordinateBytes);
  ECDSA_SIG_free(signature);
  return raw;
}

}  // namespace

std::string Base64Url(const std::string& bytes) {
  std::string text = absl::WebSafeBase64Escape(bytes);  // without padding
  return text;
}

TokenMaker::TokenMaker(std::string algorithm, std::string kid, int rsa_bits)
    : algorithm_(std::move(algorithm)),
      kid_(std::move(kid)),
      key_(algorithm_ == "RS256" ? EVP_RSA_gen(static_cast<unsigned>(rsa_bits))
                                 : EVP_EC_gen("P-256"),
           EVP_PKEY_free) {}

Json TokenMaker::Jwk() const {
  Json key = {{"kid", kid_}, {"use", "sig"}, {"alg", algorithm_}};
  if (algorithm_ == "RS256") {
    key["kty"] = "RSA";
    key["n"] = Number(key_.get(), OSSL_PKEY_PARAM_RSA_N);
    key["e"] = Number(key_.get(), OSSL_PKEY_PARAM_RSA_E);
  } else {
    key["kty"] = "EC";
    key["crv"] = "P-256";
    key["x"] = Number(key_.get(), OSSL_PKEY_PARAM_EC_PUB_X, kCoordinateBytes);
    key["y"] = Number(key_.get(), OSSL_PKEY_PARAM_EC_PUB_Y, kCoordinateBytes);
  }
  return key;
}

std::string TokenMaker::Signature(const std::string& text) const {
  const std::shared_ptr<EVP_MD_CTX> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  const auto* bytes = reinterpret_cast<const uint8_t*>(text.data());
  EVP_DigestSignInit(context.get(), nullptr, EVP_sha256(), nullptr, key_.get());
  size_t size = 0;
  EVP_DigestSign(context.get(), nullptr, &size, bytes, text.size());
  std::string signature(size, '\0');
  EVP_DigestSign(context.get(), reinterpret_cast<uint8_t*>(signature.data()), &size, bytes,
                 text.size());
  signature.resize(size);
  return algorithm_ == "RS256" ? signature : RawSignature(signature);
}

std::string TokenMaker::Sign(const Json& claims, const Json& header) const {
  Json whole = {{"alg", algorithm_}, {"kid", kid_}};
  whole.merge_patch(header);
  return SignText(whole.dump(), claims.dump());
}

std::string TokenMaker::SignText(const std::string& header, const std::string& claims) const {
  const std::string text = Base64Url(header) + "." + Base64Url(claims);
  return text + "." + Base64Url(Signature(text));
}

std::string KeySet(const std::vector<Json>& keys) { return Json{{"keys", keys}}.dump(); }

Json GoodClaims(absl::Time expires) {
  return {{"iss", "https://id.example"},
          {"aud", "latticed"},
          {"sub", "alice"},
          {"role", "edit"},
          {"tenant", "acme"},
          {"exp", absl::ToUnixSeconds(expires)}};
}

std::string SignHs256(const Json& claims, const std::string& secret) {
  const std::string text =
      Base64Url(R"({"alg":"HS256","kid":"rsa"})") + "." + Base64Url(claims.dump());
  std::string mac(EVP_MAX_MD_SIZE, '\0');
  unsigned size = 0;
  HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
       reinterpret_cast<const uint8_t*>(text.data()), text.size(),
       reinterpret_cast<uint8_t*>(mac.data()), &size);
  mac.resize(size);
  return text + "." + Base64Url(mac);
}

}  // namespace latticed::testing
