// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rows of meshes, and a lock by which the rows and the files of all servers agree.
//
//   put      file written, lock, file gets its name, row, unlock
//   delete   lock, row, file, unlock
//
// Errors   as connection.h; kNotFound
// Threads  safe
#ifndef LATTICED_SERVER_STORE_POSTGRES_MESH_ROWS_H_
#define LATTICED_SERVER_STORE_POSTGRES_MESH_ROWS_H_

#include <string_view>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "server/store/postgres/pool.h"

namespace latticed {

// Calls `publish`, then inserts the row. If the connection and so the lock is lost in between, another server may delete the
// mesh: both are done once more.
[[nodiscard]] absl::Status InsertPostgresMesh(PgPool& pool, std::string_view id,
                                              std::string_view header,
                                              absl::FunctionRef<absl::Status()> publish);
// Deletes the row, then calls `remove`, of which a failure is the caller's affair.
[[nodiscard]] absl::Status DeletePostgresMesh(PgPool& pool, std::string_view id,
                                              absl::FunctionRef<void()> remove);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_MESH_ROWS_H_
