// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/store_table.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "fmt/format.h"
#include "server/store/postgres_store.h"
#include "server/store/sqlite_store.h"
#include "tests/bench/scenario.h"
#include "tests/bench/store/edit_table.h"
#include "tests/bench/store/record_load.h"
#include "tests/bench/store/replay_table.h"
#include "tests/bench/store/restart_table.h"
#include "tests/bench/store/synced_file.h"
#include "tests/server/store/postgres_server.h"
#include "tests/support/temporary_folder.h"

namespace latticed::bench {
namespace {

using testing::PostgresServer;
using testing::TemporaryFolder;

constexpr int kStoreRounds = 5;

Measured MeasureFile(const Load& load) {
  const TemporaryFolder folder;
  auto file = std::make_unique<SyncedFile>(folder.Path("log"));
  return Drive(
      load,
      [&](int scene, uint64_t lsn, std::function<void()> done) {
        file->Append(RecordOf(scene, lsn), std::move(done));
      },
      [&] { file.reset(); });
}

template <class T>
T Take(absl::StatusOr<T> made) {
  CheckOk(made.status());
  return *std::move(made);
}

void CheckRecords(Store& store, const Load& load) {
  for (int scene = 0; scene < load.scenes; ++scene) {
    const auto log = Take(store.ReadScene(SceneId(scene)));
    bool right = log.records.size() == load.edits() / static_cast<size_t>(load.scenes);
    uint64_t lsn = 0;
    for (const std::string& record : log.records) right &= record == RecordOf(scene, ++lsn);
    if (!right) {
      CheckOk(absl::DataLossError(fmt::format("{} is not what was appended", SceneId(scene))));
    }
  }
}

// `open` opens one store, again and again.
Measured MeasureStore(const Load& load, const std::function<std::unique_ptr<Store>()>& open) {
  auto store = open();
  for (int scene = 0; scene < load.scenes; ++scene) {
    CheckOk(store->CreateScene(SceneId(scene), ""));
  }
  const Measured measured = Drive(
      load,
      [&](int scene, uint64_t lsn, std::function<void()> done) {
        store->Append(SceneId(scene), lsn, RecordOf(scene, lsn),
                      [done = std::move(done)](const absl::Status& status) {
                        CheckOk(status);
                        done();
                      });
      },
      [&] {
        store->Flush();
        store.reset();
      });
  store = open();
  for (int scene = 0; scene < load.scenes && store->shared(); ++scene) {
    CheckOk(store->ClaimScene(SceneId(scene)).status());
  }
  CheckRecords(*store, load);
  return measured;
}

Measured MeasureSqlite(const Load& load) {
  const TemporaryFolder folder;
  return MeasureStore(load, [&] { return Take(OpenSqliteStore({.folder = folder.Path("data")})); });
}

Measured MeasurePostgres(const Load& load, PostgresServer& server, bool fence = true) {
  TemporaryFolder folder;
  const std::string url = folder.Write("url", server.NewDatabase());
  return MeasureStore(load, [&] {
    return Take(OpenPostgresStore({.url_file = url,
                                   .mesh_store = folder.Path("meshes"),
                                   .name = "bench",
                                   .lease = absl::Seconds(2),
                                   .fence = fence}));
  });
}

double Median(const std::vector<Measured>& rounds, double Measured::*member) {
  std::vector<double> values;
  for (const Measured& round : rounds) values.push_back(round.*member);
  std::ranges::sort(values);
  return values[values.size() / 2];
}

std::string Times(const std::vector<Measured>& rounds) {
  return fmt::format("{:.2f} / {:.1f}", Median(rounds, &Measured::p50),
                     Median(rounds, &Measured::p99));
}

// `postgres` is null where it is not installed.
std::vector<std::string> Row(const Load& load, PostgresServer* postgres) {
  std::vector<Measured> file, sqlite, shared;
  for (int round = 0; round < kStoreRounds; ++round) {
    file.push_back(MeasureFile(load));
    sqlite.push_back(MeasureSqlite(load));
    if (postgres != nullptr) shared.push_back(MeasurePostgres(load, *postgres));
  }
  const auto ratio = [&](const std::vector<Measured>& rounds) {
    return fmt::format("{:.1f}", Median(rounds, &Measured::p99) / Median(file, &Measured::p99));
  };
  const auto written = [](const std::vector<Measured>& rounds) {
    return fmt::format("{:.1f}", Median(rounds, &Measured::written));
  };
  return {fmt::format("{} x {}", load.scenes, load.rate),
          Times(file),
          Times(sqlite),
          ratio(sqlite),
          shared.empty() ? "not installed" : Times(shared),
          shared.empty() ? "" : ratio(shared),
          written(file),
          written(sqlite)};
}

Section LatencyTable(PostgresServer* postgres) {
  Section section;
  section.title = "From an edit's due time to its durability: scenes x edits/s";
  section.columns = {"load",
                     "fdatasync p50 / p99 ms",
                     "SQLite p50 / p99 ms",
                     "p99 ratio",
                     "PostgreSQL p50 / p99 ms",
                     "p99 ratio",
                     "file: written / logged",
                     "SQLite: written / logged"};
  const std::string before = LoadOfMachine();
  for (const Load load : {Load{1, 60}, Load{10, 200}, Load{100, 200}}) {
    section.rows.push_back(Row(load, postgres));
  }
  section.notes = {fmt::format(
      "Medians of {} rounds of {} s, by turns. Load of the machine before and after: {}, {}.",
      kStoreRounds, absl::ToInt64Seconds(kRound), before, LoadOfMachine())};
  return section;
}

Section FenceTable(PostgresServer& postgres) {
  Section section;
  section.title = "What the fence of PostgreSQL's appends adds";
  section.columns = {"load", "without p50 / p99 ms", "with p50 / p99 ms", "p50 added ms"};
  for (const Load load : {Load{1, 60}, Load{10, 200}}) {
    std::vector<Measured> without, with;
    for (int round = 0; round < kStoreRounds; ++round) {
      without.push_back(MeasurePostgres(load, postgres, /*fence=*/false));
      with.push_back(MeasurePostgres(load, postgres));
    }
    section.rows.push_back(
        {fmt::format("{} x {}", load.scenes, load.rate), Times(without), Times(with),
         fmt::format("{:.2f}", Median(with, &Measured::p50) - Median(without, &Measured::p50))});
  }
  return section;
}

// Null where it is not installed.
std::unique_ptr<PostgresServer> StartPostgres() {
  if (!PostgresServer::IsInstalled()) return nullptr;
  return std::make_unique<PostgresServer>(PostgresServer::Network::kTcp,
                                          PostgresServer::Disk::kAwaited);
}

std::vector<Section> WriteTables() {
  const auto postgres = StartPostgres();
  std::vector<Section> sections = {LatencyTable(postgres.get())};
  if (postgres != nullptr) sections.push_back(FenceTable(*postgres));
  return sections;
}

struct Part {
  std::string_view name;
  std::vector<Section> (*tables)();
};
constexpr std::array kParts = {
    Part{"writes", WriteTables},
    Part{"edits", [] { return std::vector<Section>{EditTable(StartPostgres().get())}; }},
    Part{"replay", [] { return std::vector<Section>{ReplayTable()}; }},
    Part{"restart", [] { return std::vector<Section>{RestartTable()}; }},
};

}  // namespace

bool IsStorePart(std::string_view part) {
  return std::ranges::find(kParts, part, &Part::name) != kParts.end();
}

std::vector<Section> StoreTables(std::string_view part) {
  std::vector<Section> sections;
  for (const Part& each : kParts) {
    if (!part.empty() && part != each.name) continue;
    for (Section& section : each.tables()) sections.push_back(std::move(section));
  }
  return sections;
}

}  // namespace latticed::bench
