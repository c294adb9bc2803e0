// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the writer knows of scenes, and their rows. Records lie in the order of their commits, so a commit writes the
// last page of one table, however many scenes it is about. There is no index: each record names the row of the one
// before it of its scene, and the writer knows each scene's last.
//
//   row      1   2   3   4   5   6   7   8   9
//   scene    a1  b1  a2  c1  a3  b2  a4  a5  b3        previous: a5 -> a4 -> a3 -> …
//                            ^ saved_row         the last rows of all scenes up to here are in table `scene`
//                                ------------->  these are read when the database is opened
//
// Rows that a snapshot covers, and those of deleted scenes, are dead. They stay until they are swept: neighbours die at
// about the same time, so whole pages become free at once. Only rows up to saved_row are swept.
//
// Use      within a transaction of the connection, then Committed or RolledBack
// Errors   as statement.h; kNotFound, kAlreadyExists
// Threads  one: the writer's
#ifndef LATTICED_SERVER_STORE_SQLITE_SCENE_ROWS_H_
#define LATTICED_SERVER_STORE_SQLITE_SCENE_ROWS_H_

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/sqlite/database/connection.h"

namespace latticed {

// Where a scene's records are.
struct SceneTail {
  int64_t number = 0;  // never used again
  int64_t row = 0;     // of record `lsn`
  uint64_t lsn = 0;
  uint64_t snapshot_lsn = 0;
};

class SceneRows {
 public:
  // The heads are saved after so many rows: it bounds what is read when the database is opened.
  static constexpr int64_t kRowsBetweenSaves = 8'192;
  // Rows that a step of the sweep looks at, unless more were appended: some 1 ms.
  static constexpr int64_t kSweptRows = 256;

  [[nodiscard]] static absl::StatusOr<SceneRows> Create(SqliteConnection* database);

  // Reads everything anew, except which scenes are broken. kDataLoss if the rows contradict each other.
  [[nodiscard]] absl::Status Load();

  // kNotFound.
  [[nodiscard]] absl::StatusOr<SceneTail> Find(std::string_view id) const;
  // OK if record `lsn` may be appended. kNotFound; kFailedPrecondition, which breaks the scene; what broke the scene.
  [[nodiscard]] absl::Status CheckAppend(std::string_view id, uint64_t lsn);
  // What broke the scene, OK if nothing did. kNotFound.
  [[nodiscard]] absl::Status CheckSound(std::string_view id) const;
  void Break(std::string_view id, const absl::Status& why);
  void Mend(std::string_view id);

  // With a snapshot of records 1 to `lsn`, unless that is 0.
  [[nodiscard]] absl::Status Create(std::string_view id, std::string_view header, uint64_t lsn,
                                    std::string_view snapshot);
  [[nodiscard]] absl::Status Delete(std::string_view id);
  [[nodiscard]] absl::Status Append(std::string_view id, uint64_t lsn, std::string_view record);
  [[nodiscard]] absl::Status PutSnapshot(std::string_view id, uint64_t lsn, std::string_view bytes);
  // Does what has come due with the rows appended in this transaction.
  [[nodiscard]] absl::Status Maintain();
  // Saves the heads of all scenes.
  [[nodiscard]] absl::Status SaveHeads();
  // Deletes dead rows among the next `rows`.
  [[nodiscard]] absl::Status Sweep(int64_t rows = kSweptRows);

  void Committed();
  void RolledBack();

  // Whether a pause should be used to sweep.
  bool WorthSweeping() const { return dead_rows_ > live_rows_ / 8; }

 private:
  struct Scene {
    SceneTail tail;
    bool unsaved = false;
    absl::Status broken;
  };
  using Scenes = std::map<std::string, Scene, std::less<>>;

  explicit SceneRows(SqliteConnection* database) : database_(database) {}

  [[nodiscard]] absl::Status Prepare();
  [[nodiscard]] absl::Status LoadScenes(Scenes& scenes);
  // Follows the rows after saved_row.
  [[nodiscard]] absl::Status LoadTail(Scenes& scenes);
  [[nodiscard]] absl::Status WriteSnapshot(int64_t number, uint64_t lsn, std::string_view bytes);
  // Live rows die.
  [[nodiscard]] absl::Status Bury(uint64_t rows);
  void Undo(std::function<void()> undo) { undo_.push_back(std::move(undo)); }

  SqliteConnection* database_;
  Scenes scenes_;
  std::vector<SqliteStatement> statements_;  // by Sql in scene_rows.cc
  std::vector<std::function<void()>> undo_;  // of this transaction, for RolledBack
  int64_t next_row_ = 1;
  int64_t committed_row_ = 0;
  int64_t saved_row_ = 0;
  int64_t live_rows_ = 0;
  int64_t dead_rows_ = 0;
  int64_t swept_row_ = 0;      // where the sweep is
  int64_t dead_at_sweep_ = 0;  // dead rows when it began
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_SCENE_ROWS_H_
