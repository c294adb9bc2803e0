// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/restart_table.h"

#include <signal.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/load/load_edit.h"
#include "client/cpp/load/surface_verifier.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/in_process.h"
#include "server/store/sqlite_store.h"
#include "tests/bench/scenario.h"
#include "tests/bench/store/edited_history.h"
#include "tests/bench/store/knot_scene.h"
#include "tests/bench/store/record_load.h"
#include "tests/server/daemon/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace latticed::bench {
namespace {

constexpr int kKeptScenes = 100, kRestarts = 5;
constexpr uint64_t kKeptEdits = 100'000, kSnapshotEvery = 4'096, kFlushEvery = 200;
constexpr uint64_t kEditsByServer = 2;  // there and back, by which the server makes the scene's box

std::string KeptScene(int scene) { return fmt::format("scene-{}", scene); }

void MakeScenes(const std::string& folder) {
  fmt::print(stderr, "making {} scenes\n", kKeptScenes);
  const auto server =
      Checked(InProcessServer::Start({.backend = "cpu", .data_dir = folder, .log_level = "off"}));
  client::Client client(server->channel(), "");
  const std::string mesh = UploadKnot(client);
  for (int scene = 0; scene < kKeptScenes; ++scene) {
    CreateKnotScene(client, mesh, KeptScene(scene));
    const v1::LatticeState lattice = Checked(client.GetLattice(KeptScene(scene)));
    for (uint64_t step = 0; step < kEditsByServer; ++step) {
      v1::EditBatch batch = client::MakeLoadEdit(lattice, /*all_points=*/true, step);
      batch.set_scene(KeptScene(scene));
      batch.set_editor_id("bench");
      batch.set_sequence(step + 1);
      CheckOk(client.ApplyEdits(batch).status());
    }
  }
}

// Appends the edits to all scenes, and returns the history that they all have then.
SceneHistory MakeEdits(const std::string& folder) {
  const auto store = Checked(OpenSqliteStore({.folder = folder}));
  EditedHistory edited(Checked(Replay(Checked(store->ReadScene(KeptScene(0))))));
  for (uint64_t lsn = kEditsByServer + 1; lsn <= kKeptEdits; ++lsn) {
    const std::string record = edited.NextRecord();
    const std::string snapshot = lsn % kSnapshotEvery == 0 ? edited.Snapshot() : "";
    for (int scene = 0; scene < kKeptScenes; ++scene) {
      store->Append(KeptScene(scene), lsn, record, CheckOk);
      if (!snapshot.empty()) store->PutSnapshot(KeptScene(scene), lsn, snapshot);
    }
    if (lsn % kFlushEvery == 0) store->Flush();  // what waits is bounded
    if (lsn % (kKeptEdits / 10) == 0) {
      fmt::print(stderr, "appended {} edits of {} to each\n", lsn, kKeptEdits);
    }
  }
  store->Flush();
  return edited.TakeHistory();
}

// The program latticed, which ends with this object.
class KilledServer {
 public:
  explicit KilledServer(const std::string& folder)
      : daemon_({"--listen", "127.0.0.1:0", "--backend", "cpu", "--data-dir", folder}) {}
  ~KilledServer() {
    daemon_.Signal(SIGKILL);
    daemon_.Wait();
  }
  std::string Address() { return daemon_.Address(); }

 private:
  testing::Daemon daemon_;
};

absl::Status Compare(const v1::Scene& scene, const v1::LatticeState& lattice,
                     const SceneHistory& history) {
  const std::vector<Vec3d>& points = history.of(0).lattice().control_points;
  const auto& flat = lattice.lattice().control_points();
  bool same =
      scene.revision() == history.revision() && flat.size() == static_cast<int>(3 * points.size());
  for (size_t i = 0; same && i < points.size(); ++i) {
    const double* xyz = flat.data() + 3 * i;
    same = SameBits({xyz[0], xyz[1], xyz[2]}, points[i]);
  }
  return same ? absl::OkStatus() : absl::DataLossError("a scene is not what was stored");
}

// Milliseconds of each step of a restart: ready, the first three calls, and those together.
using Steps = std::vector<double>;

absl::StatusOr<Steps> Restart(const std::string& folder, const std::string& id,
                              const SceneHistory& history) {
  std::vector<absl::Time> times = {absl::Now()};
  KilledServer server(folder);
  const auto client = client::Client::Connect({.address = server.Address()});
  LATTICED_RETURN_IF_ERROR(client->CheckHealth());
  times.push_back(absl::Now());
  LATTICED_ASSIGN_OR_RETURN(const v1::Scene scene, client->GetScene(id));
  times.push_back(absl::Now());
  LATTICED_ASSIGN_OR_RETURN(const v1::LatticeState lattice, client->GetLattice(id));
  times.push_back(absl::Now());
  v1::WatchRequest request;
  request.set_scene(id);
  LATTICED_ASSIGN_OR_RETURN(const auto watch, client->Watch(request));  // its first update is whole
  times.push_back(absl::Now());

  LATTICED_RETURN_IF_ERROR(Compare(scene, lattice, history));
  client::VerifiedPoints points;
  client::SurfaceVerifier verifier(client.get(), id);
  LATTICED_RETURN_IF_ERROR(verifier.Check(watch->surface(), 0, &points));
  if (points.points == 0) return absl::DataLossError("no points were verified");
  Steps steps;
  for (size_t n = 1; n < times.size(); ++n) {
    steps.push_back(absl::ToDoubleMilliseconds(times[n] - times[n - 1]));
  }
  steps.push_back(absl::ToDoubleMilliseconds(times.back() - times[1]));
  return steps;
}

}  // namespace

Section RestartTable() {
  Section section;
  section.title = fmt::format("A restart on {} scenes of {} edits of {} points each", kKeptScenes,
                              kKeptEdits, EditedHistory::kMoved);
  if (!std::filesystem::exists(LATTICED_BINARY)) {
    section.notes = {"Not measured: there is no program " LATTICED_BINARY "."};
    return section;
  }
  const testing::TemporaryFolder folder;
  const std::string data = folder.Path("data");
  MakeScenes(data);
  const SceneHistory history = MakeEdits(data);
  const std::string before = LoadOfMachine();
  std::vector<std::vector<double>> steps;
  for (int round = 0; round < kRestarts; ++round) {
    const Steps measured =
        Checked(Restart(data, KeptScene(kKeptScenes / kRestarts * round), history));
    steps.resize(measured.size());
    for (size_t n = 0; n < measured.size(); ++n) steps[n].push_back(measured[n]);
  }
  section.notes = {fmt::format(
      "{} restarts. Load of the machine before and after: {}, {}. Files are in the page cache.",
      kRestarts, before, LoadOfMachine())};
  section.columns = {"", "median ms", "longest ms", "aim ms"};
  const std::vector<std::pair<std::string, std::string>> names = {
      {"the program started: ready", "1000"},
      {"the first GetScene of a scene", ""},
      {"its GetLattice", ""},
      {"its Watch: all bytes", ""},
      {"these three", "500"}};
  for (size_t n = 0; n < names.size(); ++n) {
    std::ranges::sort(steps[n]);
    section.rows.push_back({names[n].first, fmt::format("{:.0f}", steps[n][steps[n].size() / 2]),
                            fmt::format("{:.0f}", steps[n].back()), names[n].second});
  }
  return section;
}

}  // namespace latticed::bench
