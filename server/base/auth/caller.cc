// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth/caller.h"

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {

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

std::optional<Role> RoleFromName(std::string_view name) {
  for (const Role role : {Role::kRead, Role::kEdit, Role::kAdmin}) {
    if (RoleName(role) == name) return role;
  }
  return std::nullopt;
}

absl::Status ShareEnded() {
  return error::Unauthenticated(
      "the share of the token has expired or was revoked, or its scene was deleted");
}

absl::Status CheckRole(const Caller& caller, const Rpc& rpc) {
  if (caller.shared.has_value() && !rpc.is_for_shares) {
    return error::PermissionDenied(
        fmt::format("{} needs a token of the server; the token of a share is for one scene alone",
                    rpc.name),
        RoleName(rpc.role));
  }
  if (caller.role >= rpc.role) return absl::OkStatus();
  return error::PermissionDenied(
      fmt::format("{} needs the role '{}'; the token of '{}' has '{}'", rpc.name,
                  RoleName(rpc.role), caller.name, RoleName(caller.role)),
      RoleName(rpc.role));
}

}  // namespace latticed
