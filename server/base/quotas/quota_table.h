// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What each tenant may have at most: --quota-file, a JSON object of tenants.
//
//   {"acme": {"scenes": 100, "mesh_bytes": 10000000000},
//    "*": {"scenes": 10, "edits_per_second": 200, "watchers": 50, "bytes_per_second": 20000000}}
//
// "" is the default tenant, "*" every tenant that has no entry of its own. What an entry leaves out has no limit.
//
// Threads  immutable after loading
#ifndef LATTICED_SERVER_BASE_QUOTAS_QUOTA_TABLE_H_
#define LATTICED_SERVER_BASE_QUOTAS_QUOTA_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace latticed {

enum class QuotaKind {
  kScenes,          // in memory, and in the store
  kMeshBytes,       // of the uploads that are kept
  kEditsPerSecond,  // batches of edits
  kWatchers,        // streams that watch
  kBytesPerSecond,  // of messages to clients
  kPointSetBytes,   // of the point sets of scenes in memory
};
inline constexpr std::array kQuotaNames = {"scenes",   "mesh_bytes",       "edits_per_second",
                                           "watchers", "bytes_per_second", "point_set_bytes"};
inline const char* QuotaName(QuotaKind kind) { return kQuotaNames[static_cast<size_t>(kind)]; }

// Without a number: no limit.
class TenantQuota {
 public:
  [[nodiscard]] std::optional<uint64_t> Of(QuotaKind kind) const {
    return most_[static_cast<size_t>(kind)];
  }
  void Set(QuotaKind kind, uint64_t most) { most_[static_cast<size_t>(kind)] = most; }

 private:
  std::array<std::optional<uint64_t>, kQuotaNames.size()> most_;
};

class QuotaTable {
 public:
  // kInvalidArgument, naming the tenant and the entry that is wrong.
  [[nodiscard]] static absl::StatusOr<QuotaTable> FromText(std::string_view text);
  // The same, naming the file. Without a path nobody has a quota.
  [[nodiscard]] static absl::StatusOr<QuotaTable> FromFile(const std::string& path);

  [[nodiscard]] TenantQuota Of(std::string_view tenant) const;
  // Those with an entry of their own, without "*".
  [[nodiscard]] const std::map<std::string, TenantQuota, std::less<>>& named() const {
    return named_;
  }

 private:
  std::map<std::string, TenantQuota, std::less<>> named_;
  TenantQuota others_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_QUOTAS_QUOTA_TABLE_H_
