// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The file of the database: whose it is, and which schema it has.
//
//   scene         number, id, snapshot_lsn, saved_lsn, saved_row    one small row of what changes
//   scene_header  scene, bytes, sum                                 never changes
//   snapshot      scene, lsn, bytes, sum                            the last one
//   record        row, scene, lsn, previous, sum, bytes             in the order of commits; `previous`: the row of the
//                                                                   scene's record before
//   mesh          id, header, sum                                   the bytes are a file of mesh_folder.h
//   log           saved_row, dead_rows                              one row: scene_rows.h
//
// Errors   kFailedPrecondition in one sentence that names the file, where it belongs to another program or to a newer
//          latticed; else as statement.h
#ifndef LATTICED_SERVER_STORE_SQLITE_DATABASE_DATABASE_H_
#define LATTICED_SERVER_STORE_SQLITE_DATABASE_DATABASE_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/store/sqlite/database/connection.h"

namespace latticed {

inline constexpr uint32_t kApplicationId = 0x6C617474;  // "latt"
inline constexpr int kSchemaVersion = 2;

// Opens the database for writing, or makes it. Nobody else has it open. What a crash left in the log is in the file
// then, and the log is empty.
[[nodiscard]] absl::StatusOr<SqliteConnection> OpenDatabase(const std::string& path, bool sync);
// Opens it for reading, whether or not a server has it open. Writes nothing that is kept.
[[nodiscard]] absl::StatusOr<SqliteConnection> OpenDatabaseToRead(const std::string& path);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_DATABASE_DATABASE_H_
