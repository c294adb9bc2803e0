// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Callers from JSON web tokens (RFC 7519) that an identity provider has signed.
//
//   claim    must be
//   iss      --jwt-issuer
//   aud      --jwt-audience, alone or in a list
//   exp      required; it ends the caller's token
//   nbf      not later than now; may be missing
//   sub      the caller's name, 1 to 255 bytes of UTF-8 without control characters
//   role     read, edit or admin
//   tenant   the caller's tenant; missing: the default tenant
//
// Clocks may differ by kLeeway.
//
// Threads  immutable
#ifndef LATTICED_SERVER_BASE_AUTH_JWT_VERIFIER_H_
#define LATTICED_SERVER_BASE_AUTH_JWT_VERIFIER_H_

#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/base/auth/caller.h"
#include "server/base/auth/json_web_keys.h"

namespace latticed {

class JwtVerifier {
 public:
  static constexpr absl::Duration kLeeway = absl::Seconds(30);

  JwtVerifier(JsonWebKeys keys, std::string issuer, std::string audience)
      : keys_(std::move(keys)), issuer_(std::move(issuer)), audience_(std::move(audience)) {}

  // The caller's token may have ended: Caller::expires. kUnauthenticated, saying which check failed.
  [[nodiscard]] absl::StatusOr<Caller> CallerOf(std::string_view token, absl::Time now) const;

 private:
  JsonWebKeys keys_;
  std::string issuer_, audience_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_JWT_VERIFIER_H_
