// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// 160 watchers of a view that read at once, alone and beside 20 that do not read and 20 that take a
// message every 50 ms: the time from an edit to each one's whole update, by the real server over
// loopback, all in this process. By turns in one run; the editor's next edit comes when the 160 have
// its last.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "absl/time/clock.h"
#include "client/cpp/library/latticed_client.h"
#include "core/base/mutex.h"
#include "core/mesh/obj_io.h"
#include "server/in_process.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/server/watch_crowd.h"

namespace latticed::bench {
namespace {

using latticed::testing::WatchCrowd;

constexpr int kPrompt = 160, kStalled = 20, kSlow = 20;
constexpr absl::Duration kSlowPause = absl::Milliseconds(50);
constexpr absl::Duration kPatience = absl::Seconds(30);
constexpr uint32_t kControlPoints = 64;  // the default lattice's
constexpr int kRounds = 6, kEditsPerRound = 20, kWarmUps = 3;

// A server with one scene of 1,000 patches, Draco points, and its editor.
class Stage {
 public:
  Stage() {
    auto server = InProcessServer::Start({.backend = "cpu", .log_level = "warn"});
    CheckOk(server.status());
    server_ = *std::move(server);
    client_ = std::make_unique<client::Client>(server_->channel(), "");
    v1::MeshHeader header;
    header.set_format(v1::MESH_FORMAT_OBJ);
    const auto mesh = client_->UploadMesh(WriteObj(*MakeTorus(24, 12)), header);
    CheckOk(mesh.status());
    v1::CreateSceneRequest create;
    create.set_mesh(mesh->id());
    const auto scene = client_->CreateScene(create);
    CheckOk(scene.status());
    batch_.set_scene(scene->id());
    batch_.set_editor_id("editor");
    batch_.set_structure_id(scene->structure_id());
    watch_.set_scene(scene->id());
    watch_.set_max_unacked_updates(0);
    v1::MoveControlPoints& move = *batch_.add_edits()->mutable_move_control_points();
    for (uint32_t i = 0; i < kControlPoints; ++i) move.add_indices(i);
    move.mutable_offset()->set_x(0.01);
  }

  WatchCrowd::Options Prompt() {
    return {.count = kPrompt, .on_update = [this](uint64_t revision) { Note(revision); }};
  }
  std::unique_ptr<WatchCrowd> Watch(WatchCrowd::Options options) {
    return std::make_unique<WatchCrowd>(server_->address(), watch_, std::move(options));
  }

  // Edits, and waits until all of `crowd` have it; their times in ms.
  std::vector<double> Edit(const WatchCrowd& crowd) {
    v1::Vec3& offset = *batch_.mutable_edits(0)->mutable_move_control_points()->mutable_offset();
    offset.set_x(-offset.x());
    batch_.set_sequence(batch_.sequence() + 1);
    const absl::Time start = absl::Now();
    {
      const MutexLock lock(&mutex_);
      ends_.clear();
    }
    const auto result = client_->ApplyEdits(batch_);
    CheckOk(result.status());
    if (!crowd.WaitForRevision(result->revision(), kPatience)) {
      CheckOk(absl::DeadlineExceededError("a watcher does not get its update"));
    }
    const MutexLock lock(&mutex_);
    std::vector<double> times;
    for (const auto& [revision, end] : ends_) {
      if (revision == result->revision()) times.push_back(absl::ToDoubleMilliseconds(end - start));
    }
    return times;
  }

 private:
  void Note(uint64_t revision) {
    const absl::Time now = absl::Now();
    const MutexLock lock(&mutex_);
    ends_.emplace_back(revision, now);
  }

  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<client::Client> client_;
  v1::EditBatch batch_;
  v1::WatchRequest watch_;
  Mutex mutex_;
  std::vector<std::pair<uint64_t, absl::Time>> ends_;
};

void Round(Stage& stage, const WatchCrowd& prompt, std::vector<double>& times) {
  for (int i = 0; i < kWarmUps; ++i) stage.Edit(prompt);
  for (int i = 0; i < kEditsPerRound; ++i) {
    const std::vector<double> more = stage.Edit(prompt);
    times.insert(times.end(), more.begin(), more.end());
  }
}

double P99(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() * 99 / 100];
}

void StalledAndSlow(benchmark::State& state) {
  Stage stage;
  const auto prompt = stage.Watch(stage.Prompt());
  std::vector<double> alone, beside;
  for (int round = 0; round < kRounds; ++round) {
    Round(stage, *prompt, alone);
    const auto stalled = stage.Watch({.count = kStalled, .reads = false});
    const auto slow = stage.Watch({.count = kSlow, .pause = kSlowPause});
    Round(stage, *prompt, beside);
  }
  for (auto _ : state) state.SetIterationTime(P99(beside) * 1e-3);
  state.counters["alone_p99_ms"] = P99(alone);
  state.counters["ratio_p99"] = P99(beside) / P99(alone);
}

}  // namespace

void RegisterWatchersBenches() {
  RegisterOnce("watchers/160-with-20-stalled-20-slow", StalledAndSlow);
}

}  // namespace latticed::bench
