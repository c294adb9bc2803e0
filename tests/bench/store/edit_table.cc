// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/edit_table.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/load/load_edit.h"
#include "client/cpp/load/surface_verifier.h"
#include "fmt/format.h"
#include "server/base/options.h"
#include "server/in_process.h"
#include "tests/bench/scenario.h"
#include "tests/bench/store/knot_scene.h"
#include "tests/bench/store/record_load.h"
#include "tests/bench/store/synced_file.h"
#include "tests/support/temporary_folder.h"

namespace latticed::bench {
namespace {

constexpr char kKnot[] = "knot";
constexpr uint64_t kWarmUp = 20, kTimed = 300;

// A server with one scene, and a client that edits and watches it by one stream.
class EditedServer {
 public:
  explicit EditedServer(Options options) : options_(std::move(options)) {
    options_.backend = "cpu";
    options_.log_level = "off";
    Start();
    CreateKnotScene(*client_, UploadKnot(*client_), kKnot);
    v1::WatchRequest watch;
    watch.set_scene(kKnot);
    watch.set_editor_id("bench");
    stream_ = Checked(client_->Deform(watch));
  }

  // Milliseconds from the edit to the last byte of its update.
  double Edit(bool all_points, uint64_t step) {
    const v1::EditBatch batch =
        client::MakeLoadEdit(stream_->surface().lattice(), all_points, step);
    const absl::Time begin = absl::Now();
    const uint64_t sequence = Checked(stream_->Send(batch));
    const client::CompleteUpdate update = Checked(stream_->WaitFor(sequence));
    const absl::Duration time = absl::Now() - begin;
    if (!update.end.full_detail()) CheckOk(absl::DataLossError("an update lacks detail"));
    return absl::ToDoubleMilliseconds(time);
  }
  void Verify() {
    client::VerifiedPoints points;
    CheckOk(client::SurfaceVerifier(client_.get(), kKnot).Check(stream_->surface(), 0, &points));
    if (points.points == 0) CheckOk(absl::DataLossError("no points were verified"));
  }
  std::string Lattice() { return Checked(client_->GetLattice(kKnot)).SerializeAsString(); }
  void Restart() {
    stream_.reset();
    client_.reset();
    server_.reset();
    Start();
  }

 private:
  void Start() {
    server_ = Checked(InProcessServer::Start(options_));
    client_ = std::make_unique<client::Client>(server_->channel(), "");
  }

  Options options_;
  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<client::Client> client_;
  std::unique_ptr<client::DeformStream> stream_;
};

double Sync(SyncedFile& file, size_t bytes) {
  const absl::Time begin = absl::Now();
  absl::Notification done;
  file.Append(std::string(bytes, 'x'), [&done] { done.Notify(); });
  done.WaitForNotification();
  return absl::ToDoubleMilliseconds(absl::Now() - begin);
}

double Quantile(std::vector<double> times, double part) {
  std::ranges::sort(times);
  return times[static_cast<size_t>(part * static_cast<double>(times.size() - 1))];
}
std::string Both(const std::vector<double>& times) {
  return fmt::format("{:.2f} / {:.2f}", Quantile(times, 0.5), Quantile(times, 0.99));
}
// The median of what each turn took longer than that without durability.
std::string Added(const std::vector<double>& times, const std::vector<double>& without) {
  std::vector<double> added;
  for (size_t n = 0; n < times.size(); ++n) added.push_back(times[n] - without[n]);
  return fmt::format("{:.2f}", Quantile(added, 0.5));
}

using Servers = std::vector<std::unique_ptr<EditedServer>>;

// A row of the table: the servers' times in turns, the first one's in memory.
std::vector<std::string> EditRow(const Servers& servers, SyncedFile& file, bool all_points) {
  for (uint64_t step = 0; step < kWarmUp; ++step) {
    for (const auto& server : servers) server->Edit(all_points, step);
  }
  for (const auto& server : servers) server->Verify();
  constexpr size_t kRecord = 80, kPoint = 26;
  const size_t bytes = kRecord + kPoint * (all_points ? kKnotPoints / 2 : 1);
  std::vector<std::vector<double>> times(servers.size());
  std::vector<double> synced;
  for (uint64_t step = kWarmUp; step < kWarmUp + kTimed; ++step) {
    for (size_t turn = 0; turn < servers.size(); ++turn) {
      const size_t n = (step + turn) % servers.size();  // each comes first as often as the others
      times[n].push_back(servers[n]->Edit(all_points, step));
    }
    synced.push_back(Sync(file, bytes));
  }
  std::vector<std::string> row = {all_points ? "every second point" : "one point", Both(synced),
                                  Both(times[0])};
  for (size_t n = 1; n < times.size(); ++n) {
    row.push_back(Both(times[n]));
    row.push_back(Added(times[n], times[0]));
  }
  return row;
}

void CheckKept(const Servers& servers) {
  const std::string lattice = servers[0]->Lattice();
  for (size_t n = 1; n < servers.size(); ++n) {
    const bool same = servers[n]->Lattice() == lattice;
    servers[n]->Restart();
    if (same && servers[n]->Lattice() == lattice) continue;
    CheckOk(absl::DataLossError("a durable lattice is not the one in memory"));
  }
}

}  // namespace

Section EditTable(testing::PostgresServer* postgres) {
  testing::TemporaryFolder folder;
  Section section;
  section.title = "From an edit to all bytes of its update, 5,760 faces";
  section.columns = {"p50 / p99 ms", "fdatasync alone", "in memory", "in a folder", "added"};
  const std::string before = LoadOfMachine();
  Servers servers;
  servers.push_back(std::make_unique<EditedServer>(Options{}));
  servers.push_back(std::make_unique<EditedServer>(Options{.data_dir = folder.Path("data")}));
  if (postgres != nullptr) {
    servers.push_back(std::make_unique<EditedServer>(
        Options{.store = "postgres",
                .store_url_file = folder.Write("url", postgres->NewDatabase()),
                .mesh_store = folder.Path("meshes"),
                .advertise = "bench",
                .lease = absl::Seconds(2)}));
    section.columns.insert(section.columns.end(), {"in PostgreSQL", "added"});
  }
  SyncedFile file(folder.Path("log"));
  for (const bool all_points : {false, true}) {
    section.rows.push_back(EditRow(servers, file, all_points));
  }
  CheckKept(servers);
  section.notes = {
      fmt::format("{} edits of each, by turns. Load of the machine before and after: {}, {}.",
                  kTimed, before, LoadOfMachine()),
      "Added: the median of each turn's difference. Aim: at most 1.5 ms in a folder."};
  return section;
}

}  // namespace latticed::bench
