// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a tenant has of its quotas, where scenes and meshes are counted.
//
// Errors   kResourceExhausted, reason QUOTA_EXCEEDED; the store's
// Threads  safe
#ifndef LATTICED_SERVER_RPC_ACCESS_QUOTA_ACCESS_H_
#define LATTICED_SERVER_RPC_ACCESS_QUOTA_ACCESS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/base/quotas/quota_table.h"
#include "server/stores/mesh_store.h"

namespace latticed {

struct ServerEnv;     // server/rpc/server_env.h
struct UploadHeader;  // server/stores/upload_store.h

struct QuotaInUse {
  QuotaKind kind;
  uint64_t quota = 0, used = 0;
};
// The quotas that the tenant has, and its use of them.
[[nodiscard]] absl::StatusOr<std::vector<QuotaInUse>> QuotasOf(ServerEnv& env,
                                                               std::string_view tenant);
// For SceneRegistry::Most; null without a quota. Where servers share the store, two that make a scene in the same moment may
// both have counted before.
[[nodiscard]] absl::StatusOr<std::function<absl::Status(size_t)>> SceneQuotaCheck(
    ServerEnv& env, const std::string& tenant);
// Whether the upload could be kept if the tenant had nothing else.
[[nodiscard]] absl::Status CheckUploadQuota(ServerEnv& env, const UploadHeader& header);
// Whether the tenant may keep a mesh of so many bytes more, beside those that arrive.
[[nodiscard]] absl::Status CheckMeshQuota(ServerEnv& env, std::string_view tenant,
                                          const MeshStore::Arriving& arriving, uint64_t bytes);
// Whether the tenant's scenes here may keep so many bytes of point sets more. Two that are made in the same moment may both
// have counted before.
[[nodiscard]] absl::Status CheckPointSetQuota(ServerEnv& env, std::string_view tenant,
                                              uint64_t bytes);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_ACCESS_QUOTA_ACCESS_H_
