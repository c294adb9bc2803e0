// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A store in a folder of this machine: scenes in an SQLite database, meshes as files.
//
//   lock                 held by the server that uses the folder
//   latticed.sqlite      headers, records and snapshots; latticed.sqlite-wal and -shm while a server uses it
//   meshes/HASH          the bytes of a mesh
#ifndef LATTICED_SERVER_STORE_SQLITE_STORE_H_
#define LATTICED_SERVER_STORE_SQLITE_STORE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/store/store.h"

namespace latticed {

// When a record counts as durable.
enum class Durability {
  kFull,  // when the medium has it: it survives a loss of power
  kAsync,  // when the kernel has it: it survives the server, but a loss of power may take the last seconds
};

struct SqliteStoreOptions {
  std::string folder;  // made if it is not there
  Durability durability = Durability::kFull;
};

// Opens the folder, and repairs what a crash left half-done.
//
// Errors   in one sentence that names the folder or the file: kFailedPrecondition where another server uses it, or it is
//          another program's or a newer latticed's; kDataLoss; kUnavailable and kResourceExhausted, reason STORE
[[nodiscard]] absl::StatusOr<std::unique_ptr<Store>> OpenSqliteStore(
    const SqliteStoreOptions& options);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_STORE_H_
