// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Signs JSON web tokens as an identity provider does, with OpenSSL, and not with the library that the server uses.
#ifndef LATTICED_TESTS_SERVER_ACCESS_TOKEN_MAKER_H_
#define LATTICED_TESTS_SERVER_ACCESS_TOKEN_MAKER_H_

#include <openssl/evp.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/time/time.h"

namespace latticed::testing {

using Json = nlohmann::json;

class TokenMaker {
 public:
  // A new key for "RS256" or "ES256".
  TokenMaker(std::string algorithm, std::string kid, int rsa_bits = 2048);

  // The public key as a JWK.
  [[nodiscard]] Json Jwk() const;
  // `header` is merged into {alg, kid}; a null member removes one.
  [[nodiscard]] std::string Sign(const Json& claims, const Json& header = Json::object()) const;
  // The same for any texts, which may be no JSON.
  [[nodiscard]] std::string SignText(const std::string& header, const std::string& claims) const;
  [[nodiscard]] const std::string& kid() const { return kid_; }

 private:
  std::string Signature(const std::string& text) const;

  const std::string algorithm_, kid_;
  const std::shared_ptr<EVP_PKEY> key_;
};

[[nodiscard]] std::string Base64Url(const std::string& bytes);
// The text of a key set.
[[nodiscard]] std::string KeySet(const std::vector<Json>& keys);
// Claims that a server with issuer "https://id.example" and audience "latticed" takes.
[[nodiscard]] Json GoodClaims(absl::Time expires);
// An HS256 token whose secret is `secret`.
[[nodiscard]] std::string SignHs256(const Json& claims, const std::string& secret);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_ACCESS_TOKEN_MAKER_H_
