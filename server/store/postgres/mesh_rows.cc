// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/mesh_rows.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/store/row_sum.h"

namespace latticed {
namespace {

constexpr char kInsert[] =
    "INSERT INTO latticed.mesh(id, sum, header) VALUES($1, $2, $3) "
    "ON CONFLICT(id) DO UPDATE SET sum = EXCLUDED.sum, header = EXCLUDED.header";
constexpr char kDelete[] = "DELETE FROM latticed.mesh WHERE id = $1 RETURNING 1::bigint";

// Calls `work` while this connection has the mesh's advisory lock, which ends with the connection at the latest.
absl::Status Locked(PgConnection& connection, std::string_view id,
                    absl::FunctionRef<absl::Status()> work) {
  const int64_t key = RowSum(id, 0);
  LATTICED_RETURN_IF_ERROR(
      connection.Execute("SELECT pg_advisory_lock($1)", PgParameters().Number(key)).status());
  const absl::Status status = work();
  const absl::Status end =
      connection.Execute("SELECT pg_advisory_unlock($1)", PgParameters().Number(key)).status();
  return status.ok() && !connection.lost() ? end : status;
}

}  // namespace

absl::Status InsertPostgresMesh(PgPool& pool, std::string_view id, std::string_view header,
                                absl::FunctionRef<absl::Status()> publish) {
  return pool.With([&](PgConnection& connection) {
    return Locked(connection, id, [&]() -> absl::Status {
      LATTICED_RETURN_IF_ERROR(publish());
      return connection
          .Execute(kInsert, PgParameters().Bytes(id).Number(IdRowSum(id, header)).Bytes(header))
          .status();
    });
  });
}

absl::Status DeletePostgresMesh(PgPool& pool, std::string_view id,
                                absl::FunctionRef<void()> remove) {
  bool sent = false;  // its answer may be lost, and nobody then knows whether the row is there
  return pool.With([&](PgConnection& connection) {
    return Locked(connection, id, [&]() -> absl::Status {
      const bool again = std::exchange(sent, true);
      LATTICED_ASSIGN_OR_RETURN(const PgRows rows,
                                connection.Execute(kDelete, PgParameters().Bytes(id)));
      if (rows.empty() && !again) return error::NotFound("mesh", id);
      remove();
      return absl::OkStatus();
    });
  });
}

}  // namespace latticed
