// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/quotas/quota_table.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "absl/status/status.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/base/option_file.h"

namespace latticed {
namespace {

using Json = nlohmann::json;

constexpr char kOthers[] = "*";

absl::StatusOr<TenantQuota> QuotaOf(const std::string& tenant, const Json& entry) {
  if (!entry.is_object()) {
    return absl::InvalidArgumentError(fmt::format("the entry of '{}' is no object", tenant));
  }
  TenantQuota quota;
  for (const auto& [name, most] : entry.items()) {
    const auto known = std::ranges::find(kQuotaNames, name);
    if (known == kQuotaNames.end()) {
      return absl::InvalidArgumentError(
          fmt::format("'{}' of '{}' is not one of {}", name, tenant, fmt::join(kQuotaNames, ", ")));
    }
    if (!most.is_number_unsigned()) {
      return absl::InvalidArgumentError(
          fmt::format("'{}' of '{}' must be a whole number from 0", name, tenant));
    }
    quota.Set(static_cast<QuotaKind>(known - kQuotaNames.begin()), most.get<uint64_t>());
  }
  return quota;
}

}  // namespace

absl::StatusOr<QuotaTable> QuotaTable::FromText(std::string_view text) {
  const Json file = Json::parse(text, nullptr, false);
  if (!file.is_object()) return absl::InvalidArgumentError("is no JSON object of tenants");
  QuotaTable table;
  for (const auto& [tenant, entry] : file.items()) {
    if (!tenant.empty() && tenant != kOthers && !IsTenantName(tenant)) {
      return absl::InvalidArgumentError(
          fmt::format("'{}' is no tenant: 1 to 63 of a-z, 0-9 and '-', or \"\", or \"*\"", tenant));
    }
    LATTICED_ASSIGN_OR_RETURN(const TenantQuota quota, QuotaOf(tenant, entry));
    if (tenant == kOthers) {
      table.others_ = quota;
    } else {
      table.named_[tenant] = quota;
    }
  }
  return table;
}

absl::StatusOr<QuotaTable> QuotaTable::FromFile(const std::string& path) {
  if (path.empty()) return QuotaTable();
  constexpr std::string_view kFlag = "--quota-file";
  LATTICED_ASSIGN_OR_RETURN(const std::string text, ReadOptionFile(kFlag, path));
  auto table = FromText(text);
  if (table.ok()) return table;
  return BadOptionFile(kFlag, path, std::string(table.status().message()));
}

TenantQuota QuotaTable::Of(std::string_view tenant) const {
  const auto found = named_.find(tenant);
  return found == named_.end() ? others_ : found->second;
}

}  // namespace latticed
