// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who may call: bearer tokens of a file, and JSON web tokens. The token file has lines `sha256hex role name [tenant]`;
// blank lines and # comments are allowed. It holds hashes, so that a leaked file leaks no token. To make one:
// printf %s "$T" | sha256sum
//
// Threads  immutable after loading
#ifndef LATTICED_SERVER_BASE_AUTH_AUTHENTICATOR_H_
#define LATTICED_SERVER_BASE_AUTH_AUTHENTICATOR_H_

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "server/base/auth/caller.h"
#include "server/base/auth/jwt_verifier.h"
#include "server/base/options.h"

namespace latticed {

// The token in "Bearer <token>", whatever the case of the first word. Empty: there is none.
[[nodiscard]] std::string_view BearerToken(std::string_view authorization);

class Authenticator {
 public:
  // Without tokens: everyone is admitted as admin.
  Authenticator() = default;
  // kInvalidArgument naming the line; `text` is the content of a token file.
  [[nodiscard]] static absl::StatusOr<Authenticator> FromText(std::string_view text);
  // Reads --token-file and --jwks-file; without both, everyone is admitted. kInvalidArgument.
  [[nodiscard]] static absl::StatusOr<Authenticator> FromOptions(const Options& options);

  // Reads both files again. kInvalidArgument if one cannot be used, and then what it held stays.
  [[nodiscard]] absl::Status Renew(const Options& options);
  // The same for --jwks-file.
  [[nodiscard]] absl::Status ReadKeys(const Options& options);
  // `authorization` is the metadata value, "Bearer …", empty if absent. The caller's token may have ended
  // (Caller::expires). kUnauthenticated.
  [[nodiscard]] absl::StatusOr<Caller> Authenticate(std::string_view authorization,
                                                    absl::Time now = absl::Now()) const;
  bool open() const { return !tokens_.has_value() && jwt_ == nullptr; }

 private:
  [[nodiscard]] absl::Status ReadTokens(const Options& options);

  // By the token's hash, so that the time of a look-up tells nothing about a token.
  std::optional<std::map<std::string, Caller>> tokens_;
  std::shared_ptr<const JwtVerifier> jwt_;  // null: JSON web tokens are not taken
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_AUTHENTICATOR_H_
