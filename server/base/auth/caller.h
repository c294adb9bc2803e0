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
#include <stop_token>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace latticed {

enum class Role { kRead, kEdit, kAdmin };
[[nodiscard]] std::string_view RoleName(Role role);  // "read", "edit", "admin"
[[nodiscard]] std::optional<Role> RoleFromName(std::string_view name);

// The only scene of a caller who has the token of a share (server/stores/share_store.h).
struct SharedScene {
  std::string scene;             // its key: tenant.h
  absl::Time scene_create_time;  // which scene of that key
  std::string mesh;              // the key of its mesh
  std::stop_token ended;         // the share has expired or was revoked, or its scene was deleted
};

// Without tokens everybody is the nameless admin.
struct Caller {
  std::string name;
  Role role = Role::kAdmin;
  std::string tenant;  // empty: the default tenant
  absl::Time expires =
      absl::InfiniteFuture();  // when the token ends, and the streams that it opened
  std::optional<SharedScene> shared = std::nullopt;
};

// kUnauthenticated, for a caller with the token of a share that is no longer there.
[[nodiscard]] absl::Status ShareEnded();

// An rpc, and the role that its callers need.
struct Rpc {
  std::string_view name;  // "MeshService/UploadMesh"
  Role role;
  bool is_for_shares = false;  // also for callers with the token of a share
};
inline constexpr bool kForShares = true;

// kPermissionDenied, reason PERMISSION_DENIED, naming the role that the rpc needs.
[[nodiscard]] absl::Status CheckRole(const Caller& caller, const Rpc& rpc);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_CALLER_H_
