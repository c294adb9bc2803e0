// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth/authenticator.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/base/option_file.h"

namespace latticed {
namespace {

bool LooksLikeJwt(std::string_view token) {
  return std::ranges::count(token, '.') == 2 && token.starts_with("ey");
}

absl::StatusOr<Caller> CallerOfLine(const std::vector<std::string>& words) {
  constexpr size_t kWords = 3;  // and perhaps a tenant
  const bool has_tenant = words.size() == kWords + 1;
  if ((words.size() != kWords && !has_tenant) || !IsSha256Hex(absl::AsciiStrToLower(words[0]))) {
    return absl::InvalidArgumentError(
        "expected '<sha256 of the token, 64 hex digits> <role> <name> [<tenant>]'");
  }
  const auto role = RoleFromName(words[1]);
  if (!role.has_value()) {
    return absl::InvalidArgumentError(
        fmt::format("role '{}' is not one of read, edit, admin", words[1]));
  }
  Caller caller{.name = words[2], .role = *role};
  if (!has_tenant) return caller;
  caller.tenant = words[kWords];
  if (IsTenantName(caller.tenant)) return caller;
  return absl::InvalidArgumentError(
      fmt::format("tenant '{}' is no name of 1 to 63 of a-z, 0-9 and '-'", caller.tenant));
}

}  // namespace

absl::StatusOr<Authenticator> Authenticator::FromOptions(const Options& options) {
  Authenticator result;
  LATTICED_RETURN_IF_ERROR(result.Renew(options));
  return result;
}

absl::Status Authenticator::Renew(const Options& options) {
  const absl::Status tokens = ReadTokens(options);
  const absl::Status keys = ReadKeys(options);
  return tokens.ok() ? keys : tokens;
}

absl::Status Authenticator::ReadTokens(const Options& options) {
  if (options.token_file.empty()) return absl::OkStatus();
  const auto text = ReadFile(options.token_file);
  if (!text.ok()) {
    return absl::InvalidArgumentError(
        fmt::format("--token-file: {}", std::string(text.status().message())));
  }
  LATTICED_ASSIGN_OR_RETURN(Authenticator read, FromText(*text));
  tokens_ = std::move(read.tokens_);
  return absl::OkStatus();
}

absl::Status Authenticator::ReadKeys(const Options& options) {
  if (options.jwks_file.empty()) return absl::OkStatus();
  constexpr std::string_view kFlag = "--jwks-file";
  LATTICED_ASSIGN_OR_RETURN(const std::string text, ReadOptionFile(kFlag, options.jwks_file));
  auto keys = JsonWebKeys::FromText(text);
  if (!keys.ok()) {
    return BadOptionFile(kFlag, options.jwks_file, std::string(keys.status().message()));
  }
  jwt_ = std::make_shared<const JwtVerifier>(*std::move(keys), options.jwt_issuer,
                                             options.jwt_audience);
  return absl::OkStatus();
}

absl::StatusOr<Authenticator> Authenticator::FromText(std::string_view text) {
  Authenticator result;
  result.tokens_.emplace();
  int line_number = 0;
  const std::string content(text);
  for (const auto piece : absl::StrSplit(content, '\n')) {
    ++line_number;
    const std::string line(absl::StripAsciiWhitespace(piece));
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    const absl::StatusOr<Caller> caller = CallerOfLine(words);
    if (!caller.ok()) {
      return absl::InvalidArgumentError(fmt::format("token file, line {}: {}", line_number,
                                                    std::string(caller.status().message())));
    }
    result.tokens_->insert_or_assign(absl::AsciiStrToLower(words[0]), *caller);
  }
  if (result.tokens_->empty()) {
    return absl::InvalidArgumentError(
        "token file: contains no token, so no caller would be accepted");
  }
  return result;
}

std::string_view BearerToken(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  if (absl::AsciiStrToLower(std::string(authorization.substr(0, kScheme.size()))) != kScheme) {
    return "";
  }
  return authorization.substr(kScheme.size());
}

absl::StatusOr<Caller> Authenticator::Authenticate(std::string_view authorization,
                                                   absl::Time now) const {
  if (open()) return Caller{};
  if (authorization.empty()) {
    return error::Unauthenticated(
        "this server needs a token: send the metadata 'authorization: Bearer <token>'");
  }
  const std::string_view token = BearerToken(authorization);
  if (token.empty()) return error::Unauthenticated("authorization must read 'Bearer <token>'");
  if (tokens_.has_value()) {
    const auto known = tokens_->find(Sha256Hex(token));
    if (known != tokens_->end()) return known->second;
  }
  if (jwt_ != nullptr && LooksLikeJwt(token)) return jwt_->CallerOf(token, now);
  return error::Unauthenticated("the token is not known to this server");
}

}  // namespace latticed
