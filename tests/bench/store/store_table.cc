// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/store_table.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "fmt/format.h"
#include "server/store/sqlite_store.h"
#include "tests/bench/scenario.h"
#include "tests/bench/store/synced_file.h"

namespace latticed::bench {
namespace {

constexpr size_t kRecordBytes = 351;
constexpr int kRounds = 5;
constexpr absl::Duration kRound = absl::Seconds(4);

struct Load {
  int scenes;
  int rate;  // of each, 1/s

  size_t edits() const {
    return static_cast<size_t>(absl::ToInt64Seconds(kRound)) * static_cast<size_t>(scenes * rate);
  }
  int SceneOf(size_t edit) const { return static_cast<int>(edit % static_cast<size_t>(scenes)); }
  uint64_t LsnOf(size_t edit) const { return edit / static_cast<size_t>(scenes) + 1; }
};

struct Measured {
  double p50 = 0;  // ms
  double p99 = 0;
  double written = 0;  // bytes, divided by bytes of records
};

// A folder that goes with this object.
class WorkFolder {
 public:
  WorkFolder() {
    path_ = (std::filesystem::temp_directory_path() / "latticed-bench-XXXXXX").string();
    if (mkdtemp(path_.data()) == nullptr) throw std::runtime_error("no folder " + path_);
  }
  ~WorkFolder() { std::filesystem::remove_all(path_); }
  WorkFolder(const WorkFolder&) = delete;  // it deletes the folder
  WorkFolder& operator=(const WorkFolder&) = delete;

  std::string Path(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

std::string IdOf(int scene) { return fmt::format("scene {}", scene); }

std::string RecordOf(int scene, uint64_t lsn) {
  std::string record = fmt::format("{}, record {}: ", IdOf(scene), lsn);
  record.resize(kRecordBytes, 'x');
  return record;
}

uint64_t WrittenBytes() {
  std::ifstream io("/proc/self/io");
  for (std::string key; io >> key;) {
    uint64_t value = 0;
    io >> value;
    if (key == "write_bytes:") return value;
  }
  return 0;
}

// Calls `append` for each edit when it is due, and gives it what to call when the edit is durable. Returns milliseconds
// from due to durable, sorted.
using Append = std::function<void(int scene, uint64_t lsn, std::function<void()> done)>;
std::vector<double> Drive(const Load& load, const Append& append) {
  std::vector<absl::Time> durable(load.edits());
  const absl::Duration apart = kRound / static_cast<int64_t>(load.edits());
  const absl::Time begin = absl::Now();
  const auto due = [&](size_t edit) { return begin + apart * static_cast<int64_t>(edit); };
  for (size_t edit = 0; edit < load.edits(); ++edit) {
    if (const absl::Duration early = due(edit) - absl::Now(); early > absl::ZeroDuration()) {
      absl::SleepFor(early);
    }
    append(load.SceneOf(edit), load.LsnOf(edit), [&durable, edit] { durable[edit] = absl::Now(); });
  }
  // Waits for the last one of each scene.
  for (int scene = 0; scene < load.scenes; ++scene) append(scene, 0, nullptr);
  std::vector<double> times;
  for (size_t edit = 0; edit < load.edits(); ++edit) {
    times.push_back(absl::ToDoubleMilliseconds(durable[edit] - due(edit)));
  }
  std::ranges::sort(times);
  return times;
}

Measured Summary(const Load& load, const std::vector<double>& times, uint64_t written) {
  const double logged = static_cast<double>(load.edits() * kRecordBytes);
  return {.p50 = times[times.size() / 2],
          .p99 = times[times.size() * 99 / 100],
          .written = static_cast<double>(written) / logged};
}

Measured MeasureFile(const Load& load) {
  const WorkFolder folder;
  const uint64_t before = WrittenBytes();
  std::vector<double> times;
  {
    auto file = std::make_unique<SyncedFile>(folder.Path("log"));
    times = Drive(load, [&](int scene, uint64_t lsn, std::function<void()> done) {
      if (lsn > 0) {
        file->Append(RecordOf(scene, lsn), std::move(done));
      } else {
        file.reset();
      }
    });
  }
  return Summary(load, times, WrittenBytes() - before);
}

std::unique_ptr<Store> OpenIn(const std::string& path) {
  auto store = OpenSqliteStore({.folder = path});
  CheckOk(store.status());
  return *std::move(store);
}

void CheckRecords(Store& store, const Load& load) {
  for (int scene = 0; scene < load.scenes; ++scene) {
    const auto log = store.ReadScene(IdOf(scene));
    CheckOk(log.status());
    bool right = log->records.size() == load.edits() / static_cast<size_t>(load.scenes);
    uint64_t lsn = 0;
    for (const std::string& record : log->records) right &= record == RecordOf(scene, ++lsn);
    if (!right)
      CheckOk(absl::DataLossError(fmt::format("{} is not what was appended", IdOf(scene))));
  }
}

Measured MeasureStore(const Load& load) {
  const WorkFolder folder;
  auto store = OpenIn(folder.Path("data"));
  for (int scene = 0; scene < load.scenes; ++scene) CheckOk(store->CreateScene(IdOf(scene), ""));
  const uint64_t before = WrittenBytes();
  const std::vector<double> times =
      Drive(load, [&](int scene, uint64_t lsn, std::function<void()> done) {
        if (lsn == 0) return store->Flush();
        store->Append(IdOf(scene), lsn, RecordOf(scene, lsn), [done](const absl::Status& status) {
          CheckOk(status);
          done();
        });
      });
  store.reset();
  const uint64_t written = WrittenBytes() - before;
  CheckRecords(*OpenIn(folder.Path("data")), load);
  return Summary(load, times, written);
}

double Median(const std::vector<Measured>& rounds, double Measured::*member) {
  std::vector<double> values;
  for (const Measured& round : rounds) values.push_back(round.*member);
  std::ranges::sort(values);
  return values[values.size() / 2];
}

std::vector<std::string> Row(const Load& load) {
  std::vector<Measured> file;
  std::vector<Measured> store;
  for (int round = 0; round < kRounds; ++round) {
    file.push_back(MeasureFile(load));
    store.push_back(MeasureStore(load));
  }
  const auto times = [](const std::vector<Measured>& rounds) {
    return fmt::format("{:.2f} / {:.1f}", Median(rounds, &Measured::p50),
                       Median(rounds, &Measured::p99));
  };
  return {fmt::format("{} x {}", load.scenes, load.rate),
          times(file),
          times(store),
          fmt::format("{:.1f}", Median(store, &Measured::p99) / Median(file, &Measured::p99)),
          fmt::format("{:.1f}", Median(file, &Measured::written)),
          fmt::format("{:.1f}", Median(store, &Measured::written))};
}

std::string LoadOfMachine() {
  std::ifstream file("/proc/loadavg");
  std::string minute;
  file >> minute;
  return minute;
}

Section LatencyTable() {
  Section section;
  section.title = "From an edit's due time to its durability: scenes x edits/s";
  section.columns = {"load",      "fdatasync p50 / p99 ms", "store p50 / p99 ms",
                     "p99 ratio", "file: written / logged", "store: written / logged"};
  const std::string before = LoadOfMachine();
  for (const Load load : {Load{1, 60}, Load{10, 200}, Load{100, 200}}) {
    section.rows.push_back(Row(load));
  }
  section.notes = {fmt::format(
      "Medians of {} rounds of {} s, by turns. Load of the machine before and after: {}, {}.",
      kRounds, absl::ToInt64Seconds(kRound), before, LoadOfMachine())};
  return section;
}

// Ten scenes of 10^5 records each.
Section ReadingTable() {
  constexpr int kScenes = 10;
  constexpr uint64_t kRecords = 100'000;
  const WorkFolder folder;
  {
    const auto store = OpenIn(folder.Path("data"));
    for (int scene = 0; scene < kScenes; ++scene) CheckOk(store->CreateScene(IdOf(scene), ""));
    for (uint64_t lsn = 1; lsn <= kRecords; ++lsn) {
      for (int scene = 0; scene < kScenes; ++scene) {
        store->Append(IdOf(scene), lsn, RecordOf(scene, lsn), CheckOk);
      }
      if (lsn % 1'000 == 0) store->Flush();
    }
  }
  const absl::Time begin = absl::Now();
  const auto store = OpenIn(folder.Path("data"));
  const absl::Time opened = absl::Now();
  const auto log = store->ReadScene(IdOf(kScenes / 2));
  const absl::Time read = absl::Now();
  CheckOk(log.status());
  if (log->records.size() != kRecords) CheckOk(absl::DataLossError("records are missing"));
  Section section;
  section.title = "Ten scenes of 100,000 records each, without snapshots";
  section.columns = {"", "ms"};
  section.rows = {
      {"open the store", fmt::format("{:.0f}", absl::ToDoubleMilliseconds(opened - begin))},
      {"read one scene", fmt::format("{:.0f}", absl::ToDoubleMilliseconds(read - opened))}};
  return section;
}

}  // namespace

std::vector<Section> StoreTables() { return {LatencyTable(), ReadingTable()}; }

}  // namespace latticed::bench
