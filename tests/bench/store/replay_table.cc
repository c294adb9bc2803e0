// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/replay_table.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/ffd/edit_history.h"
#include "core/ffd/lattice.h"
#include "fmt/format.h"
#include "server/engine/scene/scene_replay.h"
#include "server/store/records/header_codec.h"
#include "server/store/records/scene_codec.h"
#include "server/store/sqlite_store.h"
#include "tests/bench/scenario.h"
#include "tests/bench/store/record_load.h"
#include "tests/support/temporary_folder.h"

namespace latticed::bench {
namespace {

constexpr uint64_t kEdits = 100'000;
constexpr int kScenes = 10;
constexpr uint32_t kPoints = 8 * 8 * 8, kMoved = 10;

Lattice Box() {
  auto lattice =
      FitLattice({.min = {0, 0, 0}, .max = {1, 1, 1}}, {8, 8, 8}, {2, 2, 2}, kDefaultPadding);
  CheckOk(lattice.status());
  return *std::move(lattice);
}

// The records of edits that an editor made one after another, a millisecond apart.
std::vector<std::string> Records() {
  EditHistory history(Box());
  std::vector<std::string> records;
  EditHistory::TimePoint now;
  for (uint64_t n = 1; n <= kEdits; ++n) {
    now += std::chrono::milliseconds(1);
    MoveControlPoints move{.offset = {0.001 * (n % 7), 0, -0.001 * (n % 5)}};
    for (uint32_t i = 0; i < kMoved; ++i) {
      move.indices.push_back(static_cast<uint32_t>((n * 31 + i * 17) % kPoints));
    }
    EditBatch batch{.editor_id = "bench", .sequence = n, .structure_id = 1, .edits = {move}};
    CheckOk(history.Apply(batch, now, [](const auto&) { return absl::OkStatus(); }).status());
    records.push_back(EncodeRecord({.edit = history.LastRecord(batch, now)}));
  }
  return records;
}

std::string Milliseconds(absl::Duration time) {
  return fmt::format("{:.0f}", absl::ToDoubleMilliseconds(time));
}

}  // namespace

Section ReplayTable() {
  const testing::TemporaryFolder folder;
  const std::vector<std::string> records = Records();
  const auto open = [&] {
    auto store = OpenSqliteStore({.folder = folder.Path("data")});
    CheckOk(store.status());
    return *std::move(store);
  };
  uint64_t bytes = 0;
  {
    const auto store = open();
    const std::string header = EncodeHeader({.lattice = Box()});
    for (int scene = 0; scene < kScenes; ++scene) {
      CheckOk(store->CreateScene(SceneId(scene), header));
    }
    for (uint64_t lsn = 1; lsn <= kEdits; ++lsn) {
      bytes += records[lsn - 1].size();
      for (int scene = 0; scene < kScenes; ++scene) {
        store->Append(SceneId(scene), lsn, records[lsn - 1], CheckOk);
      }
      if (lsn % 1'000 == 0) store->Flush();
    }
  }
  const absl::Time begin = absl::Now();
  const auto store = open();
  const absl::Time opened = absl::Now();
  const auto log = store->ReadScene(SceneId(kScenes / 2));
  CheckOk(log.status());
  const absl::Time read = absl::Now();
  const auto life = Replay(*log);
  CheckOk(life.status());
  const absl::Time replayed = absl::Now();
  if (life->history.revision() != kEdits) CheckOk(absl::DataLossError("edits are missing"));
  Section section;
  section.title = fmt::format("{} scenes of {} edits of {} points each, without snapshots", kScenes,
                              kEdits, kMoved);
  section.notes = {fmt::format("A record has {} bytes.", bytes / kEdits)};
  section.columns = {"", "ms"};
  section.rows = {{"open the store", Milliseconds(opened - begin)},
                  {"read one scene", Milliseconds(read - opened)},
                  {"make its history", Milliseconds(replayed - read)}};
  return section;
}

}  // namespace latticed::bench
