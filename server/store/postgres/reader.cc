// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/reader.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/store/row_sum.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr char kWrongSum[] = "its bytes are not those that were written";

constexpr char kScene[] =
    "SELECT number, snapshot_lsn, sum, header, coalesce(s.session = $2, false)::int::bigint "
    "FROM latticed.scene LEFT JOIN latticed.session s ON s.session = scene.session AND NOT "
    "s.fenced "
    "WHERE id = $1";
constexpr char kSnapshot[] =
    "SELECT sum, bytes FROM latticed.snapshot WHERE scene = $1 AND lsn = $2";
// A part at a time, so that a long log is not in memory twice.
constexpr char kRecords[] =
    "SELECT lsn, sum, bytes FROM latticed.record WHERE scene = $1 AND lsn > $2 ORDER BY lsn LIMIT "
    "4096";

// In microseconds.
constexpr char kUnused[] =
    "(extract(epoch FROM CASE WHEN s.session IS NULL THEN clock_timestamp() - scene.used "
    "WHEN latticed.good_until(s) > clock_timestamp() THEN interval '0' "
    "ELSE clock_timestamp() - greatest(scene.used, s.expires) END) * 1000000)::bigint";

std::string Named(std::string_view id) { return fmt::format("scene '{}'", id); }

absl::Status ReadSnapshot(PgConnection& connection, std::string_view id, int64_t number,
                          SceneLog& log) {
  if (log.snapshot_lsn == 0) return absl::OkStatus();
  const std::string name = fmt::format("{}: snapshot {}", Named(id), log.snapshot_lsn);
  LATTICED_ASSIGN_OR_RETURN(
      const PgRows rows,
      connection.Execute(kSnapshot, PgParameters().Number(number).Number(log.snapshot_lsn)));
  if (rows.empty()) return error::Damaged(name, "it is missing");
  log.snapshot = rows.Bytes(0, 1);
  if (rows.Number(0, 0) == RowSum(log.snapshot, number, log.snapshot_lsn)) return absl::OkStatus();
  return error::Damaged(name, kWrongSum);
}

absl::Status ReadRecords(PgConnection& connection, std::string_view id, int64_t number,
                         SceneLog& log) {
  while (true) {
    LATTICED_ASSIGN_OR_RETURN(
        const PgRows rows,
        connection.Execute(kRecords, PgParameters().Number(number).Number(log.lsn())));
    if (rows.empty()) return absl::OkStatus();
    for (int i = 0; i < rows.size(); ++i) {
      const uint64_t lsn = log.lsn() + 1;
      const std::string_view bytes = rows.Bytes(i, 2);
      const std::string name = fmt::format("{}: record {}", Named(id), lsn);
      if (rows.Number(i, 0) != static_cast<int64_t>(lsn)) {
        return error::Damaged(name, "it is missing");
      }
      if (rows.Number(i, 1) != RowSum(bytes, number, lsn)) return error::Damaged(name, kWrongSum);
      log.records.emplace_back(bytes);
    }
  }
}

absl::Status ReadAll(PgConnection& connection, std::optional<int64_t> session, std::string_view id,
                     PgScene& scene) {
  LATTICED_ASSIGN_OR_RETURN(
      const PgRows rows,
      connection.Execute(kScene, PgParameters().Bytes(id).Number(session.value_or(0))));
  if (rows.empty()) return error::NotFound("scene", id);
  if (session.has_value() && rows.Number(0, 4) == 0) return error::SceneNotOwned(id);
  const int64_t number = rows.Number(0, 0);
  SceneLog& log = scene.log;
  log.snapshot_lsn = static_cast<uint64_t>(rows.Number(0, 1));
  log.header = rows.Bytes(0, 3);
  if (rows.Number(0, 2) != IdRowSum(id, log.header)) {
    return error::Damaged(Named(id) + ": its header", kWrongSum);
  }
  LATTICED_RETURN_IF_ERROR(ReadSnapshot(connection, id, number, log));
  LATTICED_RETURN_IF_ERROR(ReadRecords(connection, id, number, log));
  scene.tail = {number, log.lsn()};
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PgScene> ReadPostgresScene(PgPool& pool, std::optional<int64_t> session,
                                          std::string_view id) {
  PgScene scene;
  LATTICED_RETURN_IF_ERROR(pool.With([&](PgConnection& connection) -> absl::Status {
    scene = {};
    LATTICED_RETURN_IF_ERROR(
        connection.Execute("BEGIN ISOLATION LEVEL REPEATABLE READ, READ ONLY"));
    const absl::Status status = ReadAll(connection, session, id, scene);
    const absl::Status end = connection.Execute("ROLLBACK");
    return status.ok() ? end : status;
  }));
  return scene;
}

absl::StatusOr<std::vector<StoredEntry>> ReadPostgresEntries(PgPool& pool, std::string_view kind,
                                                             const std::string_view* id) {
  std::vector<StoredEntry> entries;
  const bool scenes = kind == "scene";
  const std::string sql =
      fmt::format("SELECT id, header, sum, {} FROM latticed.{} {} {} ORDER BY id",
                  scenes ? kUnused : "0::bigint", kind,
                  scenes ? "LEFT JOIN latticed.session s ON s.session = scene.session" : "",
                  id == nullptr ? "" : "WHERE id = $1");
  LATTICED_RETURN_IF_ERROR(pool.With([&](PgConnection& connection) -> absl::Status {
    entries.clear();
    PgParameters parameters;
    if (id != nullptr) parameters.Bytes(*id);
    LATTICED_ASSIGN_OR_RETURN(const PgRows rows, connection.Execute(sql, parameters));
    for (int i = 0; i < rows.size(); ++i) {
      StoredEntry entry{.id = std::string(rows.Bytes(i, 0)),
                        .header = std::string(rows.Bytes(i, 1)),
                        .unused = absl::Microseconds(rows.Number(i, 3))};
      if (rows.Number(i, 2) != IdRowSum(entry.id, entry.header)) {
        entry.damage =
            error::Damaged(fmt::format("{} '{}': its header", kind, entry.id), kWrongSum);
        entry.header.clear();
      }
      entries.push_back(std::move(entry));
    }
    return absl::OkStatus();
  }));
  return entries;
}

absl::StatusOr<std::string> ReadPostgresHeader(PgPool& pool, std::string_view kind,
                                               std::string_view id) {
  LATTICED_ASSIGN_OR_RETURN(std::vector<StoredEntry> found, ReadPostgresEntries(pool, kind, &id));
  if (found.empty()) return error::NotFound(kind, id);
  LATTICED_RETURN_IF_ERROR(found[0].damage);
  return std::move(found[0].header);
}

}  // namespace latticed
