// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth.h"

#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/sha256.h"
#include "fmt/format.h"

namespace latticed {
namespace {

absl::StatusOr<Role> RoleFromName(std::string_view name) {
  for (const Role role : {Role::kRead, Role::kEdit, Role::kAdmin}) {
    if (RoleName(role) == name) return role;
  }
  return absl::InvalidArgumentError(fmt::format("role '{}' is not one of read, edit, admin", name));
}

}  // namespace

std::string_view RoleName(Role role) {
  switch (role) {
    case Role::kRead:
      return "read";
    case Role::kEdit:
      return "edit";
    case Role::kAdmin:
      return "admin";
  }
  return "unknown";
}

absl::StatusOr<Authenticator> Authenticator::FromFile(const std::string& path) {
  if (path.empty()) return Authenticator();
  const auto text = ReadFile(path);
  if (text.ok()) return FromText(*text);
  return absl::InvalidArgumentError(
      fmt::format("--token-file: {}", std::string(text.status().message())));
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
    if (words.size() != 3 || !IsSha256Hex(absl::AsciiStrToLower(words[0]))) {
      return absl::InvalidArgumentError(fmt::format(
          "token file, line {}: expected '<sha256 of the token, 64 hex digits> <role> <name>'",
          line_number));
    }
    const absl::StatusOr<Role> role = RoleFromName(words[1]);
    if (!role.ok()) {
      return absl::InvalidArgumentError(fmt::format("token file, line {}: {}", line_number,
                                                    std::string(role.status().message())));
    }
    result.tokens_->insert_or_assign(absl::AsciiStrToLower(words[0]), Caller{words[2], *role});
  }
  if (result.tokens_->empty()) {
    return absl::InvalidArgumentError(
        "token file: contains no token, so no caller would be accepted");
  }
  return result;
}

absl::StatusOr<Caller> Authenticator::Authenticate(std::string_view authorization) const {
  if (open()) return Caller{};
  constexpr std::string_view kScheme = "bearer ";
  if (authorization.empty()) {
    return error::Unauthenticated(
        "this server needs a token: send the metadata 'authorization: Bearer <token>'");
  }
  const std::string scheme =
      absl::AsciiStrToLower(std::string(authorization.substr(0, kScheme.size())));
  if (scheme != kScheme) {
    return error::Unauthenticated("authorization must read 'Bearer <token>'");
  }
  const auto known = tokens_->find(Sha256Hex(authorization.substr(kScheme.size())));
  if (known == tokens_->end())
    return error::Unauthenticated("the token is not known to this server");
  return known->second;
}

absl::Status CheckRole(const Caller& caller, const Rpc& rpc) {
  if (caller.role >= rpc.role) return absl::OkStatus();
  return error::PermissionDenied(
      fmt::format("{} needs the role '{}'; the token of '{}' has '{}'", rpc.name,
                  RoleName(rpc.role), caller.name, RoleName(caller.role)),
      RoleName(rpc.role));
}

}  // namespace latticed
