// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/scene_reader.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/store/row_sum.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

std::string Named(std::string_view id) { return fmt::format("scene '{}'", id); }

constexpr char kWrongSum[] = "its bytes are not those that were written";

absl::Status ReadHeader(SqliteConnection& database, std::string_view id, int64_t number,
                        SceneLog& log) {
  LATTICED_ASSIGN_OR_RETURN(
      SqliteStatement row,
      database.Prepare("SELECT snapshot_lsn, sum, bytes FROM scene LEFT JOIN scene_header ON "
                       "scene_header.scene = number WHERE number = ?"));
  row.Bind(1, number);
  LATTICED_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return error::NotFound("scene", id);
  log.snapshot_lsn = row.Unsigned(0);
  log.header = row.Bytes(2);
  if (row.Integer(1) != RowSum(log.header, number)) {
    return error::Damaged(Named(id) + ": its header", kWrongSum);
  }
  return absl::OkStatus();
}

absl::Status ReadSnapshot(SqliteConnection& database, std::string_view id, int64_t number,
                          SceneLog& log) {
  if (log.snapshot_lsn == 0) return absl::OkStatus();
  const std::string name = fmt::format("{}: snapshot {}", Named(id), log.snapshot_lsn);
  LATTICED_ASSIGN_OR_RETURN(
      SqliteStatement row,
      database.Prepare("SELECT sum, bytes FROM snapshot WHERE scene = ? AND lsn = ?"));
  row.Bind(1, number);
  row.Bind(2, log.snapshot_lsn);
  LATTICED_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return error::Damaged(name, "it is missing");
  log.snapshot = row.Bytes(1);
  if (row.Integer(0) != RowSum(log.snapshot, number, log.snapshot_lsn)) {
    return error::Damaged(name, kWrongSum);
  }
  return absl::OkStatus();
}

// From the last record to the one after the snapshot.
absl::Status ReadRecords(SqliteConnection& database, std::string_view id, const SceneTail& tail,
                         SceneLog& log) {
  if (tail.lsn <= log.snapshot_lsn) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(
      SqliteStatement record,
      database.Prepare("SELECT scene, lsn, previous, sum, bytes FROM record WHERE row = ?"));
  log.records.resize(tail.lsn - log.snapshot_lsn);
  int64_t row = tail.row;
  for (uint64_t lsn = tail.lsn; lsn > log.snapshot_lsn; --lsn) {
    const auto damaged = [&](std::string_view problem) {
      return error::Damaged(fmt::format("{}: record {}", Named(id), lsn), problem);
    };
    record.Bind(1, row);
    const absl::StatusOr<bool> found = record.Step();
    if (absl::IsDataLoss(found.status())) return damaged(std::string(found.status().message()));
    LATTICED_RETURN_IF_ERROR(found.status());
    if (!*found || record.Integer(0) != tail.number || record.Unsigned(1) != lsn) {
      return damaged("it is missing");
    }
    std::string& bytes = log.records[lsn - log.snapshot_lsn - 1];
    bytes = record.Bytes(4);
    if (record.Integer(3) != RowSum(bytes, tail.number, lsn)) return damaged(kWrongSum);
    row = record.Integer(2);
    record.Reset();
  }
  return absl::OkStatus();
}

absl::Status ReadAll(SqliteConnection& database, std::string_view id, const SceneTail& tail,
                     SceneLog& log) {
  LATTICED_RETURN_IF_ERROR(ReadHeader(database, id, tail.number, log));
  LATTICED_RETURN_IF_ERROR(ReadSnapshot(database, id, tail.number, log));
  return ReadRecords(database, id, tail, log);
}

// Rows of (id, header, sum, number): all, or that with `id`. `sum_of` gives the right sum for a row.
template <typename SumOf>
absl::StatusOr<std::vector<StoredEntry>> ReadEntries(SqliteConnection& database,
                                                     const std::string& sql, std::string_view kind,
                                                     SumOf sum_of,
                                                     std::optional<std::string_view> id = {}) {
  std::vector<StoredEntry> entries;
  const std::string whole = sql + (id ? " WHERE id = ?" : " ORDER BY id");
  LATTICED_ASSIGN_OR_RETURN(SqliteStatement rows, database.Prepare(whole.c_str()));
  if (id) rows.BindBytes(1, *id);
  while (true) {
    LATTICED_ASSIGN_OR_RETURN(const bool found, rows.Step());
    if (!found) return entries;
    StoredEntry entry{std::string(rows.Bytes(0)), std::string(rows.Bytes(1)), {}};
    if (rows.Integer(2) != sum_of(rows, entry)) {
      entry.damage = error::Damaged(fmt::format("{} '{}': its header", kind, entry.id), kWrongSum);
      entry.header.clear();
    }
    entries.push_back(std::move(entry));
  }
}

}  // namespace

absl::StatusOr<SceneLog> SceneReader::Read(std::string_view id, const SceneTail& tail) {
  LATTICED_ASSIGN_OR_RETURN(Connection database, Take());
  LATTICED_RETURN_IF_ERROR(database->Execute("BEGIN"));
  SceneLog log;
  const absl::Status status = ReadAll(*database, id, tail, log);
  LATTICED_RETURN_IF_ERROR(status);  // closes the connection, whatever it is in
  LATTICED_RETURN_IF_ERROR(database->Execute("ROLLBACK"));
  GiveBack(std::move(database));
  return log;
}

absl::StatusOr<std::vector<StoredEntry>> SceneReader::Scenes() { return ReadScenes({}); }

absl::StatusOr<std::vector<StoredEntry>> SceneReader::Meshes() { return ReadMeshes({}); }

absl::StatusOr<std::vector<StoredEntry>> SceneReader::Shares() {
  return ReadByIdSum("SELECT id, header, sum FROM share", "share", {});
}

absl::StatusOr<std::string> SceneReader::SceneHeader(std::string_view id) {
  LATTICED_ASSIGN_OR_RETURN(std::vector<StoredEntry> found, ReadScenes(id));
  if (found.empty()) return error::NotFound("scene", id);
  LATTICED_RETURN_IF_ERROR(found[0].damage);
  return std::move(found[0].header);
}

absl::StatusOr<std::string> SceneReader::MeshHeader(std::string_view id) {
  LATTICED_ASSIGN_OR_RETURN(std::vector<StoredEntry> found, ReadMeshes(id));
  if (found.empty()) return error::NotFound("mesh", id);
  LATTICED_RETURN_IF_ERROR(found[0].damage);
  return std::move(found[0].header);
}

absl::StatusOr<std::vector<StoredEntry>> SceneReader::ReadScenes(
    std::optional<std::string_view> id) {
  LATTICED_ASSIGN_OR_RETURN(Connection database, Take());
  LATTICED_ASSIGN_OR_RETURN(
      std::vector<StoredEntry> entries,
      ReadEntries(
          *database,
          "SELECT id, bytes, sum, number FROM scene LEFT JOIN scene_header ON "
          "scene_header.scene = number",
          "scene",
          [](const SqliteStatement& row, const StoredEntry& entry) {
            return RowSum(entry.header, row.Integer(3));
          },
          id));
  GiveBack(std::move(database));
  return entries;
}

absl::StatusOr<std::vector<StoredEntry>> SceneReader::ReadMeshes(
    std::optional<std::string_view> id) {
  return ReadByIdSum("SELECT id, header, sum FROM mesh", "mesh", id);
}

absl::StatusOr<std::vector<StoredEntry>> SceneReader::ReadByIdSum(
    const std::string& sql, std::string_view kind, std::optional<std::string_view> id) {
  LATTICED_ASSIGN_OR_RETURN(Connection database, Take());
  LATTICED_ASSIGN_OR_RETURN(std::vector<StoredEntry> entries,
                            ReadEntries(
                                *database, sql, kind,
                                [](const SqliteStatement&, const StoredEntry& entry) {
                                  return IdRowSum(entry.id, entry.header);
                                },
                                id));
  GiveBack(std::move(database));
  return entries;
}

absl::StatusOr<bool> SceneReader::HasMesh(std::string_view id) {
  LATTICED_ASSIGN_OR_RETURN(Connection database, Take());
  absl::StatusOr<bool> found;
  {
    LATTICED_ASSIGN_OR_RETURN(SqliteStatement row,
                              database->Prepare("SELECT 1 FROM mesh WHERE id = ?"));
    row.BindBytes(1, id);
    found = row.Step();
  }
  GiveBack(std::move(database));
  return found;
}

absl::StatusOr<SceneReader::Connection> SceneReader::Take() {
  {
    MutexLock lock(&mutex_);
    if (!unused_.empty()) {
      Connection connection = std::move(unused_.back());
      unused_.pop_back();
      return connection;
    }
  }
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection connection, sync_
                                                             ? SqliteConnection::Open(path_, *sync_)
                                                             : SqliteConnection::OpenToRead(path_));
  return std::make_unique<SqliteConnection>(std::move(connection));
}

void SceneReader::GiveBack(Connection connection) {
  MutexLock lock(&mutex_);
  unused_.push_back(std::move(connection));
}

}  // namespace latticed
