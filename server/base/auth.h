// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bearer tokens and roles. The token file has lines `sha256hex role name`; blank lines and # comments are
// allowed. It holds hashes, so that a leaked file leaks no token. To make one: printf %s "$T" | sha256sum
//
// Roles    read < edit < admin; each rpc names the one that it needs beside its handler, in server/rpc
// Threads  immutable after loading
#ifndef LATTICED_SERVER_BASE_AUTH_H_
#define LATTICED_SERVER_BASE_AUTH_H_

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

enum class Role { kRead, kEdit, kAdmin };
[[nodiscard]] std::string_view RoleName(Role role);  // "read", "edit", "admin"

// Who calls. Without a token file everybody is the nameless admin.
struct Caller {
  std::string name;
  Role role = Role::kAdmin;
};

// An rpc, and the role that its callers need.
struct Rpc {
  std::string_view name;  // "MeshService/UploadMesh"
  Role role;
};

class Authenticator {
 public:
  // Without tokens: everyone is admitted as admin.
  Authenticator() = default;
  // kInvalidArgument naming the line; `text` is the content of a token file.
  [[nodiscard]] static absl::StatusOr<Authenticator> FromText(std::string_view text);
  // Reads --token-file; an empty path admits everyone. kInvalidArgument.
  [[nodiscard]] static absl::StatusOr<Authenticator> FromFile(const std::string& path);

  // `authorization` is the metadata value, "Bearer …", empty if absent. kUnauthenticated.
  [[nodiscard]] absl::StatusOr<Caller> Authenticate(std::string_view authorization) const;
  bool open() const { return !tokens_.has_value(); }

 private:
  // By the token's hash, so that the time of a look-up tells nothing about a token.
  std::optional<std::map<std::string, Caller>> tokens_;
};

// kPermissionDenied, reason PERMISSION_DENIED, naming the role that the rpc needs.
[[nodiscard]] absl::Status CheckRole(const Caller& caller, const Rpc& rpc);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_H_
