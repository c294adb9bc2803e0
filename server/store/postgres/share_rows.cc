// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/share_rows.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/store/row_sum.h"

namespace latticed {
namespace {

constexpr char kPut[] =
    "INSERT INTO latticed.share(id, scene, sum, header) "
    "SELECT $1, number, $3, $4 FROM latticed.scene WHERE id = $2 "
    "ON CONFLICT(id) DO UPDATE SET scene = EXCLUDED.scene, sum = EXCLUDED.sum, "
    "header = EXCLUDED.header RETURNING 1::bigint";

}  // namespace

absl::Status PutPostgresShare(PgPool& pool, std::string_view id, std::string_view scene,
                              std::string_view header) {
  return pool.With([&](PgConnection& connection) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(
        const PgRows rows,
        connection.Execute(
            kPut,
            PgParameters().Bytes(id).Bytes(scene).Number(IdRowSum(id, header)).Bytes(header)));
    return rows.empty() ? error::NotFound("scene", scene) : absl::OkStatus();
  });
}

absl::Status DeletePostgresShare(PgPool& pool, std::string_view id) {
  return pool.With([&](PgConnection& connection) {
    return connection.Execute("DELETE FROM latticed.share WHERE id = $1", PgParameters().Bytes(id))
        .status();
  });
}

absl::StatusOr<std::string> ReadPostgresSharesMark(PgPool& pool) {
  std::string mark;
  LATTICED_RETURN_IF_ERROR(pool.With([&](PgConnection& connection) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(
        const PgRows rows,
        connection.Execute("SELECT count(*), coalesce(sum(number), 0)::bigint FROM latticed.share",
                           {}));
    mark = fmt::format("{} {}", rows.Number(0, 0), rows.Number(0, 1));
    return absl::OkStatus();
  }));
  return mark;
}

}  // namespace latticed
