// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/objects/mesh_names.h"

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"

namespace latticed {

bool IsMeshId(std::string_view id) {
  const std::string_view tenant = TenantOf(id);
  return IsSha256Hex(IdOf(id)) && id == TenantKey(tenant, IdOf(id)) &&
         (tenant.empty() || IsTenantName(tenant));
}

std::string MeshName(std::string_view id) {
  const std::string_view tenant = TenantOf(id);
  return tenant.empty() ? std::string(id) : fmt::format("{}.{}", IdOf(id), tenant);
}

bool IsMeshName(std::string_view name) { return IsSha256Hex(name.substr(0, name.find('.'))); }

}  // namespace latticed
