// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// store_child FOLDER full|async SCENES
//
// Appends to scenes s0, s1, … of a store, and puts meshes, until it is killed. Prints "SCENE LSN" for each acknowledged
// record and "mesh/HASH 1" for each mesh, at once.
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/time/clock.h"
#include "core/base/sha256.h"
#include "server/store/sqlite_store.h"
#include "tests/server/store/crash/numbered_records.h"

namespace latticed::testing {
namespace {

constexpr uint64_t kRecordsPerSnapshot = 97;
// For each scene: it bounds what one commit holds.
constexpr int kMostUnanswered = 2;

void Say(std::string_view what, uint64_t lsn) {
  const std::string line = fmt::format("{} {}\n", what, lsn);
  if (write(STDOUT_FILENO, line.data(), line.size()) < 0) std::_Exit(1);
}

void PutMesh(Store& store, std::string_view scene, uint64_t lsn) {
  const std::string bytes = SnapshotOf(scene, lsn);
  const std::string id = Sha256Hex(bytes);
  if (!store.PutMesh(id, HeaderOf(id), bytes).ok()) std::_Exit(1);
  Say("mesh/" + id, 1);
}

int Main(const std::string& folder, std::string_view durability, int scenes) {
  auto store = OpenSqliteStore(
      {.folder = folder,
       .durability = durability == "full" ? Durability::kFull : Durability::kAsync});
  if (!store.ok()) {
    std::fprintf(stderr, "%s\n", store.status().ToString().c_str());
    return 1;
  }
  std::map<std::string, uint64_t> last;
  for (int i = 0; i < scenes; ++i) {
    const std::string scene = fmt::format("s{}", i);
    (*store)->CreateScene(scene, HeaderOf(scene)).IgnoreError();  // it exists already
    const absl::StatusOr<SceneLog> log = (*store)->ReadScene(scene);
    if (!log.ok()) return 1;
    last[scene] = log->lsn();
  }
  std::atomic<int> unanswered = 0;
  while (true) {
    for (auto& entry : last) {
      const std::string& scene = entry.first;
      const uint64_t lsn = ++entry.second;
      while (unanswered >= kMostUnanswered * scenes) absl::SleepFor(absl::Microseconds(50));
      ++unanswered;
      (*store)->Append(scene, lsn, RecordOf(scene, lsn),
                       [&unanswered, scene, lsn](const absl::Status& status) {
                         if (!status.ok()) std::_Exit(1);
                         Say(scene, lsn);
                         --unanswered;
                       });
      if (lsn % kRecordsPerSnapshot != 0) continue;
      (*store)->PutSnapshot(scene, lsn, SnapshotOf(scene, lsn));
      PutMesh(**store, scene, lsn);
    }
  }
}

}  // namespace
}  // namespace latticed::testing

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  return latticed::testing::Main(argv[1], argv[2], std::atoi(argv[3]));
}
