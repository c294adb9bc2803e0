// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth/jwt_verifier.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/strings/ascii.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"

namespace latticed {
namespace {

using Json = nlohmann::json;

constexpr size_t kMostNameBytes = 255;
constexpr double kMostSeconds = 1e15;  // of a time, so that it fits absl::Time

std::string ClaimOf(const Json& claims, const char* name) {
  const auto found = claims.find(name);
  return found != claims.end() && found->is_string() ? found->get<std::string>() : "";
}

// A time in seconds since 1970. kUnauthenticated if the claim is something else.
absl::StatusOr<std::optional<absl::Time>> TimeOf(const Json& claims, const char* name) {
  const auto found = claims.find(name);
  if (found == claims.end()) return std::nullopt;
  const double seconds = found->is_number() ? found->get<double>() : NAN;
  if (!(std::abs(seconds) <= kMostSeconds)) {
    return error::Unauthenticated(fmt::format("the token's '{}' is no time", name));
  }
  return absl::UnixEpoch() + absl::Seconds(seconds);
}

bool IsFor(const Json& claims, const std::string& audience) {
  const auto found = claims.find("aud");
  if (found == claims.end()) return false;
  if (found->is_string()) return *found == audience;
  return found->is_array() && std::ranges::find(*found, Json(audience)) != found->end();
}

absl::StatusOr<Caller> CallerFrom(const Json& claims) {
  Caller caller{.name = ClaimOf(claims, "sub"), .tenant = ClaimOf(claims, "tenant")};
  const bool plain = std::ranges::none_of(
      caller.name, [](char c) { return absl::ascii_iscntrl(static_cast<unsigned char>(c)); });
  if (caller.name.empty() || caller.name.size() > kMostNameBytes || !plain) {
    return error::Unauthenticated(
        fmt::format("the token's 'sub' must be a name of 1 to {} bytes", kMostNameBytes));
  }
  const auto role = RoleFromName(ClaimOf(claims, "role"));
  if (!role.has_value()) {
    return error::Unauthenticated("the token's 'role' must be read, edit or admin");
  }
  caller.role = *role;
  if (claims.contains("tenant") && !IsTenantName(caller.tenant)) {
    return error::Unauthenticated(
        "the token's 'tenant' must be a name of 1 to 63 of a-z, 0-9 and '-'");
  }
  return caller;
}

}  // namespace

absl::StatusOr<Caller> JwtVerifier::CallerOf(std::string_view token, absl::Time now) const {
  LATTICED_ASSIGN_OR_RETURN(const std::string payload, keys_.Verify(token));
  const Json claims = Json::parse(payload, nullptr, false);
  if (!claims.is_object()) return error::Unauthenticated("the token holds no claims");
  if (ClaimOf(claims, "iss") != issuer_) {
    return error::Unauthenticated("the token's issuer ('iss') is not this server's --jwt-issuer");
  }
  if (!IsFor(claims, audience_)) {
    return error::Unauthenticated("the token is not for this server's --jwt-audience ('aud')");
  }
  LATTICED_ASSIGN_OR_RETURN(const auto not_before, TimeOf(claims, "nbf"));
  if (not_before.has_value() && *not_before > now + kLeeway) {
    return error::Unauthenticated("the token is not valid yet ('nbf')");
  }
  LATTICED_ASSIGN_OR_RETURN(const auto expires, TimeOf(claims, "exp"));
  if (!expires.has_value())
    return error::Unauthenticated("the token never expires: 'exp' is missing");
  LATTICED_ASSIGN_OR_RETURN(Caller caller, CallerFrom(claims));
  caller.expires = *expires + kLeeway;
  return caller;
}

}  // namespace latticed
