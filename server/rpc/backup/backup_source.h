// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a backup copies: each mesh, and after it its scenes. With a store all is read from there, what is in memory too:
// a scene is then as it is stored, nothing is woken, and no edit waits.
//
//   Open -> Next, Next, … -> nullopt
//
// Threads  one at a time
#ifndef LATTICED_SERVER_RPC_BACKUP_BACKUP_SOURCE_H_
#define LATTICED_SERVER_RPC_BACKUP_BACKUP_SOURCE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "latticed/v1/backup.pb.h"
#include "server/engine/memory/memory_budget.h"
#include "server/store/store.h"

namespace latticed {

struct ServerEnv;

inline constexpr uint32_t kBackupFormat = 1;  // BackupStart.format
// SHA-256 of what BackupItem.sha256 covers.
[[nodiscard]] std::string BackupSum(const v1::BackupItem& item, std::string_view header,
                                    std::string_view content);

// An item and its data.
struct BackupCopy {
  v1::BackupItem item;
  std::string header;
  std::shared_ptr<const std::string> content;
  MemoryReservation room;  // for the data
};

class BackupSource {
 public:
  // `env` outlives this. What is copied is the tenant's, and charged to `account`.
  BackupSource(ServerEnv* env, std::string tenant, MemoryAccountPtr account)
      : env_(*env), tenant_(std::move(tenant)), account_(std::move(account)) {}

  // Finds what there is: all, or these scenes and their meshes. kNotFound; kInvalidArgument for one that is named twice;
  // the store's errors.
  [[nodiscard]] absl::Status Open(const std::vector<std::string>& scenes);
  // Passes over what was deleted meanwhile. What is damaged is an item that says so. kResourceExhausted; the store's
  // errors.
  [[nodiscard]] absl::StatusOr<std::optional<BackupCopy>> Next();

 private:
  struct Place {
    std::string mesh, scene;  // keys (server/base/auth/tenant.h); of a mesh: scene is empty
    absl::Status damage;      // that was seen in a list
  };

  [[nodiscard]] absl::StatusOr<std::vector<Place>> Scenes();
  [[nodiscard]] absl::StatusOr<BackupCopy> Copy(const Place& place);
  [[nodiscard]] absl::Status CopyMesh(const std::string& id, BackupCopy& copy);
  [[nodiscard]] absl::Status CopyScene(const std::string& id, BackupCopy& copy);
  [[nodiscard]] absl::StatusOr<SceneLog> ReadLog(const std::string& id, MemoryReservation& room);

  ServerEnv& env_;
  const std::string tenant_;
  const MemoryAccountPtr account_;
  std::vector<Place> places_;
  size_t next_ = 0;
  std::set<std::string> lost_meshes_;  // damaged or deleted: so are their scenes
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_BACKUP_BACKUP_SOURCE_H_
