// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/access/tenant_access.h"

#include "core/base/error.h"
#include "server/base/auth/tenant.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"

namespace latticed {

std::string KeyFor(const CallInfo& call, std::string_view id) {
  return TenantKey(call.caller.tenant, id);
}

absl::Status ToldById(const absl::Status& status, std::string_view kind, std::string_view id) {
  return absl::IsNotFound(status) ? error::NotFound(kind, id) : status;
}

absl::StatusOr<std::shared_ptr<const StoredMesh>> FindMesh(ServerEnv& env, const CallInfo& call,
                                                           std::string_view id) {
  const std::string key = KeyFor(call, id);
  const auto& shared = call.caller.shared;
  if (shared.has_value() && shared->mesh != key) return error::NotFound("mesh", id);
  auto mesh = env.meshes.Find(key);
  if (mesh.ok()) return mesh;
  return ToldById(mesh.status(), "mesh", id);
}

}  // namespace latticed
