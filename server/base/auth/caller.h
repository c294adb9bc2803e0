// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who calls, and what they may do.
//
// Roles    read < edit < admin; each rpc names the one that it needs beside its handler, in server/rpc
// Threads  plain data
#ifndef LATTICED_SERVER_BASE_AUTH_CALLER_H_
#define LATTICED_SERVER_BASE_AUTH_CALLER_H_

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace latticed {

enum class Role { kRead, kEdit, kAdmin };
[[nodiscard]] std::string_view RoleName(Role role);  // "read", "edit", "admin"
[[nodiscard]] std::optional<Role> RoleFromName(std::string_view name);

// Without tokens everybody is the nameless admin.
struct Caller {
  std::string name;
  Role role = Role::kAdmin;
  std::string tenant;  // empty: the default tenant
  absl::Time expires =
      absl::InfiniteFuture();  // when the token ends, and the streams that it opened
};

// An rpc, and the role that its callers need.
struct Rpc {
  std::string_view name;  // "MeshService/UploadMesh"
  Role role;
};

// kPermissionDenied, reason PERMISSION_DENIED, naming the role that the rpc needs.
[[nodiscard]] absl::Status CheckRole(const Caller& caller, const Rpc& rpc);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_CALLER_H_
