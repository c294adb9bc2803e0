// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A set of public keys that sign tokens (JWKS, RFC 7517), by the library cjose.
//
// Only RS256, with 2,048 bits or more, and ES256 sign. Other keys of the set are left out. The algorithm must fit the
// key, so a public key is never taken for a secret (HS256), and "none" fits no key.
//
// Threads  immutable after loading
#ifndef LATTICED_SERVER_BASE_AUTH_JSON_WEB_KEYS_H_
#define LATTICED_SERVER_BASE_AUTH_JSON_WEB_KEYS_H_

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

struct _cjose_jwk_int;

namespace latticed {

class JsonWebKeys {
 public:
  static constexpr size_t kMostKeys = 64;
  static constexpr size_t kMostTokenBytes = 4096;  // proxies take 5 KiB of headers

  // kInvalidArgument: the text is no key set, or holds no key that may sign, or a private key.
  [[nodiscard]] static absl::StatusOr<JsonWebKeys> FromText(std::string_view text);

  // The payload of a token (JWS in compact form, RFC 7515) that one of the keys has signed. kUnauthenticated, saying
  // what is wrong.
  [[nodiscard]] absl::StatusOr<std::string> Verify(std::string_view token) const;
  size_t size() const { return keys_.size(); }

 private:
  struct Key {
    std::string id;         // kid; may be empty
    std::string algorithm;  // RS256 or ES256
    std::shared_ptr<_cjose_jwk_int> key;
  };
  [[nodiscard]] absl::StatusOr<const Key*> Find(std::string_view algorithm,
                                                std::string_view id) const;

  std::vector<Key> keys_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_JSON_WEB_KEYS_H_
