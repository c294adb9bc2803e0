// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Takes the parts of a backup, and makes a mesh or a scene of each item. The bytes may be anybody's, so all that a server
// relies on is checked before anything is made. The bytes of an item are reserved as they come.
//
//   Take(start) -> Take(item) -> Take(data) … -> is_whole -> Store -> Take(item) … -> Take(end) -> Finish
//
// Errors   those of BackupService.Restore; after one, it is of no use
// Threads  one at a time
#ifndef LATTICED_SERVER_RPC_BACKUP_RESTORER_H_
#define LATTICED_SERVER_RPC_BACKUP_RESTORER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "latticed/v1/backup.pb.h"
#include "server/engine/memory/memory_budget.h"
#include "server/store/store.h"
#include "server/stores/upload_store.h"

namespace latticed {

struct CallInfo;
struct ServerEnv;

class Restorer {
 public:
  // Both outlive this.
  Restorer(ServerEnv* env, const CallInfo* call, bool skip_existing)
      : env_(*env), call_(*call), skip_existing_(skip_existing) {}

  [[nodiscard]] absl::Status Take(const v1::BackupPart& part);
  // Whether all bytes of an item have come: the next call is Store.
  bool is_whole() const { return is_open_ && missing_ == 0; }
  // Makes it, which may take seconds.
  [[nodiscard]] absl::Status Store();
  // After the last part.
  [[nodiscard]] absl::StatusOr<v1::RestoreResponse> Finish() const;

 private:
  [[nodiscard]] absl::Status TakeStart(const v1::BackupStart& start);
  [[nodiscard]] absl::Status TakeItem(const v1::BackupItem& item);
  [[nodiscard]] absl::Status TakeData(std::string_view data);
  [[nodiscard]] absl::Status TakeEnd(const v1::BackupEnd& end);
  [[nodiscard]] absl::Status StoreItem();
  [[nodiscard]] absl::Status StoreMesh(CompleteUpload upload);
  [[nodiscard]] absl::Status StoreScene(CompleteUpload upload);
  // Runs `check` with the memory that the item's bytes may take.
  [[nodiscard]] absl::Status WithinMemory(const std::function<absl::Status()>& check) const;
  // The error of the item that is under way.
  [[nodiscard]] absl::Status Named(const absl::Status& status) const;
  // The owner of what is made, if it is not the one of the backup.
  [[nodiscard]] std::optional<std::string> NewOwner() const;

  ServerEnv& env_;
  const CallInfo& call_;
  const bool skip_existing_;
  bool is_started_ = false, is_ended_ = false;
  uint64_t parts_ = 0;
  v1::RestoreResponse done_;

  // The item under way.
  bool is_open_ = false;
  v1::BackupItem item_;
  uint64_t missing_ = 0;  // bytes
  std::string header_;
  MemoryReservation header_room_;
  std::shared_ptr<Upload> content_;  // null: it has none
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_BACKUP_RESTORER_H_
