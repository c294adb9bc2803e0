// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/replay_table.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/ffd/history/edit_history.h"
#include "core/ffd/lattice.h"
#include "fmt/format.h"
#include "server/engine/scene/scene_replay.h"
#include "server/store/records/header_codec.h"
#include "server/store/sqlite_store.h"
#include "tests/bench/scenario.h"
#include "tests/bench/store/edited_history.h"
#include "tests/bench/store/record_load.h"
#include "tests/support/temporary_folder.h"

namespace latticed::bench {
namespace {

constexpr uint64_t kEdits = 100'000;
constexpr int kScenes = 10;

Lattice Box() {
  auto lattice =
      FitLattice({.min = {0, 0, 0}, .max = {1, 1, 1}}, {8, 8, 8}, {2, 2, 2}, kDefaultPadding);
  CheckOk(lattice.status());
  return *std::move(lattice);
}

// Elapsed time, and this process's own. A busy machine makes only the first longer.
struct Times {
  absl::Time wall = absl::Now();
  double user = UserMilliseconds();

  std::vector<std::string> Until(const Times& end, const std::string& what) const {
    return {what, fmt::format("{:.0f}", absl::ToDoubleMilliseconds(end.wall - wall)),
            fmt::format("{:.0f}", end.user - user)};
  }

 private:
  static double UserMilliseconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return absl::ToDoubleMilliseconds(absl::DurationFromTimeval(usage.ru_utime));
  }
};

}  // namespace

Section ReplayTable() {
  const testing::TemporaryFolder folder;
  EditedHistory edited({.history = SceneHistory({Box()})});
  const auto open = [&] {
    auto store = OpenSqliteStore({.folder = folder.Path("data")});
    CheckOk(store.status());
    return *std::move(store);
  };
  uint64_t bytes = 0;
  {
    const auto store = open();
    const std::string header = EncodeHeader({.lattices = {Box()}});
    for (int scene = 0; scene < kScenes; ++scene) {
      CheckOk(store->CreateScene(SceneId(scene), header));
    }
    for (uint64_t lsn = 1; lsn <= kEdits; ++lsn) {
      const std::string record = edited.NextRecord();
      bytes += record.size();
      for (int scene = 0; scene < kScenes; ++scene) {
        store->Append(SceneId(scene), lsn, record, CheckOk);
      }
      if (lsn % 1'000 == 0) store->Flush();
    }
  }
  const Times begin;
  const auto store = open();
  const Times opened;
  const auto log = store->ReadScene(SceneId(kScenes / 2));
  CheckOk(log.status());
  const Times read;
  const auto life = Replay(*log);
  CheckOk(life.status());
  const Times replayed;
  const auto& points = life->history.of(0).lattice().control_points;
  const auto& expected = edited.history().of(0).lattice().control_points;
  if (life->history.revision() != kEdits || !std::ranges::equal(points, expected, SameBits)) {
    CheckOk(absl::DataLossError("the history is not the one that was stored"));
  }
  Section section;
  section.title = fmt::format("{} scenes of {} edits of {} points each, without snapshots", kScenes,
                              kEdits, EditedHistory::kMoved);
  section.notes = {
      fmt::format("A record has {} bytes. Aim: read and made within 2,500 ms.", bytes / kEdits)};
  section.columns = {"", "ms", "of the processor's user time"};
  section.rows = {begin.Until(opened, "open the store"), opened.Until(read, "read one scene"),
                  read.Until(replayed, "make its history"), opened.Until(replayed, "both")};
  return section;
}

}  // namespace latticed::bench
