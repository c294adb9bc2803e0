// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/database/database.h"

#include <sqlite3.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <fstream>

#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/store/sqlite/database/checked_vfs.h"
#include "server/store/sqlite/database/wal_check.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr char kSchema[] = R"sql(
CREATE TABLE scene(
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  id BLOB NOT NULL UNIQUE,
  snapshot_lsn INTEGER NOT NULL DEFAULT 0,
  saved_lsn INTEGER NOT NULL DEFAULT 0,
  saved_row INTEGER NOT NULL DEFAULT 0) STRICT;
CREATE TABLE scene_header(scene INTEGER PRIMARY KEY, sum INTEGER NOT NULL, bytes BLOB NOT NULL) STRICT;
CREATE TABLE snapshot(
  scene INTEGER PRIMARY KEY, lsn INTEGER NOT NULL, sum INTEGER NOT NULL, bytes BLOB NOT NULL) STRICT;
CREATE TABLE record(
  row INTEGER PRIMARY KEY,
  scene INTEGER NOT NULL,
  lsn INTEGER NOT NULL,
  previous INTEGER NOT NULL,
  sum INTEGER NOT NULL,
  bytes BLOB NOT NULL) STRICT;
CREATE TABLE mesh(id BLOB PRIMARY KEY, sum INTEGER NOT NULL, header BLOB NOT NULL) STRICT, WITHOUT ROWID;
CREATE TABLE log(
  one INTEGER PRIMARY KEY CHECK(one = 1), saved_row INTEGER NOT NULL, dead_rows INTEGER NOT NULL) STRICT;
INSERT INTO log VALUES(1, 0, 0);
)sql";
constexpr char kShares[] = R"sql(
CREATE TABLE share(
  id BLOB PRIMARY KEY, scene INTEGER NOT NULL, sum INTEGER NOT NULL, header BLOB NOT NULL) STRICT, WITHOUT ROWID;
CREATE INDEX share_of_scene ON share(scene);
)sql";
// Upgrade i leads from version i to i + 1.
constexpr std::array<const char*, kSchemaVersion> kUpgrades = {kSchema, kShares};

// Damage is where it was when it is looked for again. What a server is writing is not.
constexpr int kLooksAtUsedLog = 3;

// The header of a database, as https://www.sqlite.org/fileformat2.html#the_database_header numbers its bytes.
constexpr size_t kDatabaseHeaderBytes = 100;
constexpr std::string_view kDatabaseMagic("SQLite format 3\0", 16);
constexpr size_t kReservedAt = 20;
constexpr size_t kVersionAt = 60;
constexpr size_t kApplicationIdAt = 68;

absl::Status Foreign(const std::string& path) {
  return absl::FailedPreconditionError(
      fmt::format("{} is not a database of latticed, or its first page is damaged", path));
}

absl::Status CheckVersion(const std::string& path, int64_t version) {
  if (version <= kSchemaVersion) return absl::OkStatus();
  return absl::FailedPreconditionError(
      fmt::format("{} has schema {}, and this latticed knows up to {}: use the newer latticed that "
                  "wrote it",
                  path, version, kSchemaVersion));
}

// Looks at the file before SQLite does, which would write a log beside it. A file without application_id may be one
// that a crash left while it was made.
absl::Status CheckHeader(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, kDatabaseHeaderBytes> header = {};
  if (!file || file.peek() == std::ifstream::traits_type::eof()) return absl::OkStatus();
  if (!file.read(header.data(), header.size())) return Foreign(path);
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<uint8_t>(header[i]);
    return value;
  };
  const uint32_t owner = number(kApplicationIdAt);
  if (!std::string_view(header.data(), header.size()).starts_with(kDatabaseMagic) ||
      header[kReservedAt] != kPageChecksumBytes || (owner != kApplicationId && owner != 0)) {
    return Foreign(path);
  }
  return CheckVersion(path, number(kVersionAt));
}

// In one transaction: after a crash, or on a full disk, the database has the version that it had.
absl::Status UpgradeSchema(SqliteConnection& database, int64_t version) {
  LATTICED_RETURN_IF_ERROR(database.Execute("BEGIN IMMEDIATE"));
  for (auto step = static_cast<size_t>(version); step < kUpgrades.size(); ++step) {
    LATTICED_RETURN_IF_ERROR(database.Execute(kUpgrades[step]));
  }
  const std::string mark = fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                       kApplicationId, kSchemaVersion);
  LATTICED_RETURN_IF_ERROR(database.Execute(mark.c_str()));
  return database.Execute("COMMIT");
}

absl::Status CheckSchema(SqliteConnection& database, const std::string& path) {
  LATTICED_ASSIGN_OR_RETURN(const int64_t owner, database.Number("PRAGMA application_id"));
  LATTICED_ASSIGN_OR_RETURN(const int64_t version, database.Number("PRAGMA user_version"));
  LATTICED_ASSIGN_OR_RETURN(const int64_t tables,
                            database.Number("SELECT count(*) FROM sqlite_schema"));
  const bool writable = sqlite3_db_readonly(database.get(), "main") == 0;
  if (owner == 0 && tables == 0 && writable) return UpgradeSchema(database, 0);
  if (owner != kApplicationId) return Foreign(path);
  LATTICED_RETURN_IF_ERROR(CheckVersion(path, version));
  if (version < 1) return error::Damaged(path, "it has no version of its schema");
  if (version == kSchemaVersion) return absl::OkStatus();
  if (writable) return UpgradeSchema(database, version);
  return absl::FailedPreconditionError(fmt::format(
      "{} has schema {}: a start of latticed on it upgrades it to {}, then it can be read", path,
      version, kSchemaVersion));
}

}  // namespace

absl::StatusOr<SqliteConnection> OpenDatabase(const std::string& path, bool sync) {
  LATTICED_RETURN_IF_ERROR(CheckHeader(path));
  LATTICED_RETURN_IF_ERROR(CheckWal(path + "-wal"));
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection database, SqliteConnection::Open(path, sync));
  int reserved = kPageChecksumBytes;
  LATTICED_RETURN_IF_ERROR(database.Status(
      sqlite3_file_control(database.get(), "main", SQLITE_FCNTL_RESERVE_BYTES, &reserved)));
  const std::string page = fmt::format("PRAGMA page_size = {}", kDatabasePageBytes);
  LATTICED_RETURN_IF_ERROR(database.Execute(page.c_str()));
  LATTICED_RETURN_IF_ERROR(database.Execute("PRAGMA journal_mode = WAL"));
  LATTICED_RETURN_IF_ERROR(CheckSchema(database, path));
  // The next commits begin a new log. CheckWal would take what two crashes left in one log for damage.
  LATTICED_RETURN_IF_ERROR(database.Status(sqlite3_wal_checkpoint_v2(
      database.get(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr)));
  return database;
}

absl::StatusOr<SqliteConnection> OpenDatabaseToRead(const std::string& path) {
  LATTICED_RETURN_IF_ERROR(CheckHeader(path));
  absl::Status log = CheckWal(path + "-wal");
  for (int look = 1; !log.ok() && look < kLooksAtUsedLog; ++look) log = CheckWal(path + "-wal");
  LATTICED_RETURN_IF_ERROR(log);
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection database, SqliteConnection::OpenToRead(path));
  LATTICED_RETURN_IF_ERROR(CheckSchema(database, path));
  return database;
}

}  // namespace latticed
