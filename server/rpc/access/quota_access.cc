// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/access/quota_access.h"

#include <algorithm>

#include "absl/time/clock.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/rpc/server_env.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"
#include "server/wire/stored_mesh.h"

namespace latticed {
namespace {

absl::StatusOr<size_t> StoredScenesOf(ServerEnv& env, std::string_view tenant) {
  if (env.store == nullptr || !env.store->shared()) return 0;  // the registry knows all
  LATTICED_ASSIGN_OR_RETURN(const auto stored, env.scenes->Stored());
  return static_cast<size_t>(std::ranges::count_if(
      stored, [tenant](const StoredEntry& entry) { return TenantOf(entry.id) == tenant; }));
}

absl::StatusOr<uint64_t> MeshBytesOf(ServerEnv& env, std::string_view tenant,
                                     const MeshStore::Arriving& arriving) {
  LATTICED_ASSIGN_OR_RETURN(const auto meshes, env.meshes.List());
  uint64_t bytes = 0;
  for (const auto& [id, size] : arriving) bytes += TenantOf(id) == tenant ? size : 0;
  for (const ListedMesh& mesh : meshes) {
    if (TenantOf(mesh.id) != tenant || arriving.contains(mesh.id)) continue;
    if (mesh.mesh != nullptr) {
      bytes += mesh.mesh->bytes->size();
    } else if (const auto listed = ListedFromStored(mesh.header); listed.ok()) {
      bytes += listed->total_bytes();
    }
  }
  return bytes;
}

uint64_t PointSetBytesOf(ServerEnv& env, std::string_view tenant) {
  uint64_t bytes = 0;
  for (const auto& scene : env.scenes->All()) {
    if (TenantOf(scene->id()) == tenant) bytes += scene->point_sets().MemoryBytes();
  }
  return bytes;
}

absl::StatusOr<uint64_t> UsedOf(ServerEnv& env, std::string_view tenant, QuotaKind kind) {
  if (kind == QuotaKind::kPointSetBytes) return PointSetBytesOf(env, tenant);
  if (kind == QuotaKind::kMeshBytes) return MeshBytesOf(env, tenant, {});
  if (kind != QuotaKind::kScenes) return env.quotas.Used(tenant, kind, absl::Now());
  LATTICED_ASSIGN_OR_RETURN(const size_t stored, StoredScenesOf(env, tenant));
  return std::max(stored, env.scenes->CountOfTenant(tenant));
}

}  // namespace

absl::StatusOr<std::vector<QuotaInUse>> QuotasOf(ServerEnv& env, std::string_view tenant) {
  const TenantQuota quota = env.quotas.Of(tenant);
  std::vector<QuotaInUse> uses;
  for (size_t i = 0; i < kQuotaNames.size(); ++i) {
    const auto kind = static_cast<QuotaKind>(i);
    const auto most = quota.Of(kind);
    if (!most.has_value()) continue;
    LATTICED_ASSIGN_OR_RETURN(const uint64_t used, UsedOf(env, tenant, kind));
    uses.push_back({kind, *most, used});
  }
  return uses;
}

absl::StatusOr<std::function<absl::Status(size_t)>> SceneQuotaCheck(ServerEnv& env,
                                                                    const std::string& tenant) {
  if (!env.quotas.Of(tenant).Of(QuotaKind::kScenes).has_value()) return nullptr;
  LATTICED_ASSIGN_OR_RETURN(const size_t stored, StoredScenesOf(env, tenant));
  return [&env, tenant, stored](size_t here) {
    return env.quotas.Check(tenant, QuotaKind::kScenes, std::max(stored, here), 1);
  };
}

absl::Status CheckUploadQuota(ServerEnv& env, const UploadHeader& header) {
  return env.quotas.Check(header.mesh.tenant, QuotaKind::kMeshBytes, 0, header.total_bytes);
}

absl::Status CheckMeshQuota(ServerEnv& env, std::string_view tenant,
                            const MeshStore::Arriving& arriving, uint64_t bytes) {
  if (!env.quotas.Of(tenant).Of(QuotaKind::kMeshBytes).has_value()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const uint64_t used, MeshBytesOf(env, tenant, arriving));
  return env.quotas.Check(tenant, QuotaKind::kMeshBytes, used, bytes);
}

absl::Status CheckPointSetQuota(ServerEnv& env, std::string_view tenant, uint64_t bytes) {
  if (!env.quotas.Of(tenant).Of(QuotaKind::kPointSetBytes).has_value()) return absl::OkStatus();
  return env.quotas.Check(tenant, QuotaKind::kPointSetBytes, PointSetBytesOf(env, tenant), bytes);
}

}  // namespace latticed
