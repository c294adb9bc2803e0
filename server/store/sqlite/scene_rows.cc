// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/scene_rows.h"

#include <algorithm>
#include <cstddef>
#include <unordered_map>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/store/row_sum.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

enum Sql : size_t {
  kInsertScene,
  kInsertHeader,
  kDeleteScene,
  kDeleteHeader,
  kDeleteSnapshot,
  kDeleteShares,
  kInsertRecord,
  kReplaceSnapshot,
  kSetSnapshotLsn,
  kAddDeadRows,
  kSaveScene,
  kSaveRow,
  kEndOfStep,
  kSweepStep,
  kSqlCount
};

constexpr const char* kSql[kSqlCount] = {
    "INSERT INTO scene(id, saved_lsn, snapshot_lsn) VALUES(?1, ?2, ?2)",
    "INSERT INTO scene_header(scene, sum, bytes) VALUES(?, ?, ?)",
    "DELETE FROM scene WHERE number = ?",
    "DELETE FROM scene_header WHERE scene = ?",
    "DELETE FROM snapshot WHERE scene = ?",
    "DELETE FROM share WHERE scene = ?",
    "INSERT INTO record(row, scene, lsn, previous, sum, bytes) VALUES(?, ?, ?, ?, ?, ?)",
    "REPLACE INTO snapshot(scene, lsn, sum, bytes) VALUES(?, ?, ?, ?)",
    "UPDATE scene SET snapshot_lsn = ?2 WHERE number = ?1",
    "UPDATE log SET dead_rows = max(dead_rows + ?, 0)",
    "UPDATE scene SET saved_lsn = ?2, saved_row = ?3 WHERE number = ?1",
    "UPDATE log SET saved_row = ?",
    "SELECT row FROM record WHERE row > ?1 AND row <= ?2 ORDER BY row LIMIT 1 OFFSET ?3",
    ("DELETE FROM record WHERE row > ?1 AND row <= ?2 AND NOT EXISTS "
     "(SELECT 1 FROM scene WHERE number = record.scene AND snapshot_lsn < record.lsn)"),
};

// While edits come, sweeping begins only when it pays: more rows are dead than alive, and than these.
constexpr int64_t kFewDeadRows = 65'536;

}  // namespace

absl::StatusOr<SceneRows> SceneRows::Create(SqliteConnection* database) {
  SceneRows rows(database);
  LATTICED_RETURN_IF_ERROR(rows.Prepare());
  LATTICED_RETURN_IF_ERROR(rows.Load());
  return rows;
}

absl::Status SceneRows::Prepare() {
  for (const char* sql : kSql) {
    LATTICED_ASSIGN_OR_RETURN(SqliteStatement statement, database_->Prepare(sql));
    statements_.push_back(std::move(statement));
  }
  return absl::OkStatus();
}

absl::Status SceneRows::Load() {
  Scenes scenes;
  LATTICED_RETURN_IF_ERROR(LoadScenes(scenes));
  LATTICED_RETURN_IF_ERROR(LoadTail(scenes));
  live_rows_ = 0;
  for (auto& [id, scene] : scenes) {
    live_rows_ += static_cast<int64_t>(scene.tail.lsn - scene.tail.snapshot_lsn);
    const auto before = scenes_.find(id);
    if (before != scenes_.end()) scene.broken = std::move(before->second.broken);
  }
  scenes_ = std::move(scenes);
  committed_row_ = next_row_ - 1;
  undo_.clear();
  return absl::OkStatus();
}

absl::Status SceneRows::LoadScenes(Scenes& scenes) {
  LATTICED_ASSIGN_OR_RETURN(SqliteStatement log,
                            database_->Prepare("SELECT saved_row, dead_rows FROM log"));
  LATTICED_RETURN_IF_ERROR(log.Step().status());
  saved_row_ = log.Integer(0);
  dead_rows_ = log.Integer(1);
  swept_row_ = 0;
  dead_at_sweep_ = 0;
  LATTICED_ASSIGN_OR_RETURN(
      SqliteStatement rows,
      database_->Prepare("SELECT id, number, saved_row, saved_lsn, snapshot_lsn FROM scene"));
  while (true) {
    LATTICED_ASSIGN_OR_RETURN(const bool found, rows.Step());
    if (!found) return absl::OkStatus();
    scenes[std::string(rows.Bytes(0))].tail = {
        .number = rows.Integer(1),
        .row = rows.Integer(2),
        .lsn = rows.Unsigned(3),
        .snapshot_lsn = rows.Unsigned(4),
    };
  }
}

absl::Status SceneRows::LoadTail(Scenes& scenes) {
  std::unordered_map<int64_t, Scenes::value_type*> by_number;
  for (auto& entry : scenes) by_number[entry.second.tail.number] = &entry;
  next_row_ = saved_row_ + 1;
  LATTICED_ASSIGN_OR_RETURN(
      SqliteStatement rows,
      database_->Prepare(
          "SELECT row, scene, lsn, previous FROM record WHERE row > ? ORDER BY row"));
  rows.Bind(1, saved_row_);
  while (true) {
    LATTICED_ASSIGN_OR_RETURN(const bool found, rows.Step());
    if (!found) return absl::OkStatus();
    const int64_t row = rows.Integer(0);
    if (row != next_row_) {
      return error::Damaged(
          sqlite3_db_filename(database_->get(), "main"),
          fmt::format("rows {} to {} of records are missing", next_row_, row - 1));
    }
    ++next_row_;
    const auto entry = by_number.find(rows.Integer(1));
    if (entry == by_number.end()) continue;  // deleted
    auto& [id, scene] = *entry->second;
    const uint64_t lsn = rows.Unsigned(2);
    if (lsn != scene.tail.lsn + 1 || rows.Integer(3) != scene.tail.row) {
      return error::Damaged(fmt::format("scene '{}'", id),
                            fmt::format("record {} follows record {}", lsn, scene.tail.lsn));
    }
    scene.tail.lsn = lsn;
    scene.tail.row = row;
    scene.unsaved = true;
  }
}

absl::StatusOr<SceneTail> SceneRows::Find(std::string_view id) const {
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  return found->second.tail;
}

absl::Status SceneRows::CheckAppend(std::string_view id, uint64_t lsn) {
  LATTICED_RETURN_IF_ERROR(CheckSound(id));
  Scene& scene = scenes_.find(id)->second;
  if (lsn != scene.tail.lsn + 1) scene.broken = error::NotNextRecord(id, scene.tail.lsn + 1, lsn);
  return scene.broken;
}

absl::Status SceneRows::CheckSound(std::string_view id) const {
  const auto found = scenes_.find(id);
  return found == scenes_.end() ? error::NotFound("scene", id) : found->second.broken;
}

void SceneRows::Break(std::string_view id, const absl::Status& why) {
  const auto found = scenes_.find(id);
  if (found != scenes_.end()) found->second.broken = why;
}

void SceneRows::Mend(std::string_view id) {
  const auto found = scenes_.find(id);
  if (found != scenes_.end()) found->second.broken = absl::OkStatus();
}

absl::Status SceneRows::Create(std::string_view id, std::string_view header, uint64_t lsn,
                               std::string_view snapshot) {
  if (scenes_.contains(id)) return error::AlreadyExists("scene", id);
  SqliteStatement& scene = statements_[kInsertScene];
  scene.BindBytes(1, id);
  scene.Bind(2, lsn);
  LATTICED_RETURN_IF_ERROR(scene.Run());
  const int64_t number = sqlite3_last_insert_rowid(database_->get());
  SqliteStatement& row = statements_[kInsertHeader];
  row.Bind(1, number);
  row.Bind(2, RowSum(header, number));
  row.BindBytes(3, header);
  LATTICED_RETURN_IF_ERROR(row.Run());
  if (lsn > 0) LATTICED_RETURN_IF_ERROR(WriteSnapshot(number, lsn, snapshot));
  const SceneTail tail{.number = number, .lsn = lsn, .snapshot_lsn = lsn};
  const auto made = scenes_.emplace(id, Scene{.tail = tail}).first;
  Undo([this, made] { scenes_.erase(made); });
  return absl::OkStatus();
}

absl::Status SceneRows::Delete(std::string_view id) {
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  const SceneTail tail = found->second.tail;
  for (const Sql sql : {kDeleteScene, kDeleteHeader, kDeleteSnapshot, kDeleteShares}) {
    statements_[sql].Bind(1, tail.number);
    LATTICED_RETURN_IF_ERROR(statements_[sql].Run());
  }
  LATTICED_RETURN_IF_ERROR(Bury(tail.lsn - tail.snapshot_lsn));
  Undo([this, key = found->first, scene = found->second] { scenes_.emplace(key, scene); });
  scenes_.erase(found);
  return absl::OkStatus();
}

absl::Status SceneRows::Append(std::string_view id, uint64_t lsn, std::string_view record) {
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  Scene& scene = found->second;
  SqliteStatement& row = statements_[kInsertRecord];
  row.Bind(1, next_row_);
  row.Bind(2, scene.tail.number);
  row.Bind(3, lsn);
  row.Bind(4, scene.tail.row);
  row.Bind(5, RowSum(record, scene.tail.number, lsn));
  row.BindBytes(6, record);
  LATTICED_RETURN_IF_ERROR(row.Run());
  Undo([this, &scene, before = scene.tail, unsaved = scene.unsaved] {
    scene.tail = before;
    scene.unsaved = unsaved;
    --next_row_;
    --live_rows_;
  });
  scene.tail.lsn = lsn;
  scene.tail.row = next_row_++;
  scene.unsaved = true;
  ++live_rows_;
  return absl::OkStatus();
}

absl::Status SceneRows::WriteSnapshot(int64_t number, uint64_t lsn, std::string_view bytes) {
  SqliteStatement& snapshot = statements_[kReplaceSnapshot];
  snapshot.Bind(1, number);
  snapshot.Bind(2, lsn);
  snapshot.Bind(3, RowSum(bytes, number, lsn));
  snapshot.BindBytes(4, bytes);
  return snapshot.Run();
}

absl::Status SceneRows::PutSnapshot(std::string_view id, uint64_t lsn, std::string_view bytes) {
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  SceneTail& tail = found->second.tail;
  if (lsn <= tail.snapshot_lsn || lsn > tail.lsn) {
    return error::NotNextRecord(id, tail.lsn, lsn);
  }
  LATTICED_RETURN_IF_ERROR(WriteSnapshot(tail.number, lsn, bytes));
  SqliteStatement& scene = statements_[kSetSnapshotLsn];
  scene.Bind(1, tail.number);
  scene.Bind(2, lsn);
  LATTICED_RETURN_IF_ERROR(scene.Run());
  LATTICED_RETURN_IF_ERROR(Bury(lsn - tail.snapshot_lsn));
  Undo([&tail, before = tail.snapshot_lsn] { tail.snapshot_lsn = before; });
  tail.snapshot_lsn = lsn;
  return absl::OkStatus();
}

absl::Status SceneRows::Bury(uint64_t rows) {
  const auto dead = static_cast<int64_t>(rows);
  statements_[kAddDeadRows].Bind(1, dead);
  LATTICED_RETURN_IF_ERROR(statements_[kAddDeadRows].Run());
  Undo([this, dead] {
    dead_rows_ -= dead;
    live_rows_ += dead;
  });
  dead_rows_ += dead;
  live_rows_ -= dead;
  return absl::OkStatus();
}

absl::Status SceneRows::Maintain() {
  if (next_row_ - 1 - saved_row_ >= kRowsBetweenSaves) LATTICED_RETURN_IF_ERROR(SaveHeads());
  if (dead_rows_ <= kFewDeadRows || dead_rows_ <= live_rows_) return absl::OkStatus();
  // Twice as fast as rows come.
  return Sweep(std::max(kSweptRows, 2 * (next_row_ - 1 - committed_row_)));
}

absl::Status SceneRows::SaveHeads() {
  for (auto& entry : scenes_) {
    Scene& scene = entry.second;
    if (!scene.unsaved) continue;
    SqliteStatement& row = statements_[kSaveScene];
    row.Bind(1, scene.tail.number);
    row.Bind(2, scene.tail.lsn);
    row.Bind(3, scene.tail.row);
    LATTICED_RETURN_IF_ERROR(row.Run());
    Undo([&scene] { scene.unsaved = true; });
    scene.unsaved = false;
  }
  statements_[kSaveRow].Bind(1, next_row_ - 1);
  LATTICED_RETURN_IF_ERROR(statements_[kSaveRow].Run());
  Undo([this, before = saved_row_] { saved_row_ = before; });
  saved_row_ = next_row_ - 1;
  return absl::OkStatus();
}

absl::Status SceneRows::Sweep(int64_t rows) {
  Undo([this, row = swept_row_, dead = dead_at_sweep_] {
    swept_row_ = row;
    dead_at_sweep_ = dead;
  });
  if (swept_row_ == 0) dead_at_sweep_ = dead_rows_;
  SqliteStatement& end = statements_[kEndOfStep];
  end.Bind(1, swept_row_);
  end.Bind(2, saved_row_);
  end.Bind(3, rows - 1);
  const absl::StatusOr<bool> more = end.Step();
  const int64_t last = more.ok() && *more ? end.Integer(0) : saved_row_;
  end.Reset();
  LATTICED_RETURN_IF_ERROR(more.status());

  SqliteStatement& step = statements_[kSweepStep];
  step.Bind(1, swept_row_);
  step.Bind(2, last);
  LATTICED_RETURN_IF_ERROR(step.Run());
  swept_row_ = last;
  if (*more) return absl::OkStatus();
  // Rows that died meanwhile may have been behind the sweep: they wait for the next one.
  swept_row_ = 0;
  statements_[kAddDeadRows].Bind(1, -dead_at_sweep_);
  LATTICED_RETURN_IF_ERROR(statements_[kAddDeadRows].Run());
  Undo([this, before = dead_rows_] { dead_rows_ = before; });
  dead_rows_ = std::max<int64_t>(dead_rows_ - dead_at_sweep_, 0);
  return absl::OkStatus();
}

void SceneRows::Committed() {
  undo_.clear();
  committed_row_ = next_row_ - 1;
}

void SceneRows::RolledBack() {
  for (auto undo = undo_.rbegin(); undo != undo_.rend(); ++undo) (*undo)();
  undo_.clear();
}

}  // namespace latticed
