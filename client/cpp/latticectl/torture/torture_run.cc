// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/torture/torture_run.h"

#include <thread>
#include <utility>

#include "absl/time/clock.h"
#include "client/cpp/latticectl/torture/random_edits.h"
#include "client/cpp/latticectl/torture/scene_model.h"
#include "client/cpp/latticectl/torture/torture_editor.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr absl::Duration kCheckPeriod = absl::Seconds(1);
constexpr absl::Duration kShowPeriod = absl::Milliseconds(250);
constexpr absl::Duration kTick = absl::Milliseconds(20);

absl::Status OfScene(const std::string& scene, const absl::Status& status) {
  const std::string text = fmt::format("scene {}: {}", scene, std::string(status.message()));
  return error::WithDetails(absl::Status(status.code(), text), error::DetailsOf(status));
}

class TortureRun {
 public:
  TortureRun(const TorturePlan& plan, const std::stop_token& stop) : plan_(plan), stop_(stop) {}

  absl::Status Open(const std::string& id, std::unique_ptr<Client> client) {
    LATTICED_ASSIGN_OR_RETURN(const auto state, client->GetLattice(id));
    LATTICED_ASSIGN_OR_RETURN(auto lattice, FromProto(state.lattice()));
    scenes_.push_back(std::make_unique<TorturedScene>(id, std::move(lattice), std::move(client)));
    return absl::OkStatus();
  }

  absl::Status Run(const std::function<void(const std::string&)>& show) {
    end_ = absl::Now() + absl::Seconds(plan_.seconds);
    std::vector<std::thread> threads;
    uint32_t number = 0;
    for (const auto& scene : scenes_) {
      for (int editor = 0; editor < plan_.editors; ++editor) {
        threads.emplace_back([this, &scene = *scene, editor, seed = plan_.seed + number++] {
          Edit(scene, seed, static_cast<uint32_t>(editor));
        });
      }
    }
    std::jthread checker([this](const std::stop_token& last) {
      while (!last.stop_requested()) {
        const absl::Time next = absl::Now() + kCheckPeriod;
        for (const auto& scene : scenes_) Check(*scene);
        while (!last.stop_requested() && absl::Now() < next) absl::SleepFor(kTick);
      }
    });
    for (absl::Time shown = absl::InfinitePast(); !Ended(); absl::SleepFor(kTick)) {
      if (absl::Now() - shown < kShowPeriod) continue;
      show(counts_.Line());
      shown = absl::Now();
    }
    for (std::thread& thread : threads) thread.join();
    checker.request_stop();
    checker.join();
    for (const auto& scene : scenes_) Check(*scene);
    return status();
  }

  TortureReport Report() const {
    TortureReport report = counts_.Report();
    for (const auto& scene : scenes_) report.faults.Add(scene->model.faults());
    report.seed = plan_.seed;
    return report;
  }

 private:
  struct TorturedScene {
    TorturedScene(std::string id, Lattice lattice, std::unique_ptr<Client> its_client)
        : model(std::move(id), std::move(lattice)), client(std::move(its_client)) {}
    SceneModel model;
    const std::unique_ptr<Client> client;
  };

  bool Ended() const { return stop_.stop_requested() || !status().ok() || absl::Now() >= end_; }

  void Edit(TorturedScene& scene, uint32_t seed, uint32_t number) {
    TortureEditor editor({.client = scene.client.get(),
                          .model = &scene.model,
                          .counts = &counts_,
                          .period = absl::Seconds(1 / plan_.rate)},
                         RandomEdits(seed, number, static_cast<uint32_t>(plan_.editors)));
    const auto ended = [&] { return Ended() || !scene.model.intact(); };
    Take(editor.Run(ended), scene);
  }

  void Check(TorturedScene& scene) {
    if (!scene.model.intact() || !status().ok()) return;
    const uint64_t newest = scene.model.newest();
    const auto state = scene.client->GetLattice(scene.model.scene());
    Take(state.status(), scene);
    if (!state.ok()) return;
    scene.model.Check(newest, *state);
    counts_.Checked();
  }

  void Take(const absl::Status& status, TorturedScene& scene) {
    if (status.ok()) return;
    if (absl::IsNotFound(status) || absl::IsDataLoss(status)) return scene.model.Gone(status);
    const MutexLock lock(&mutex_);
    status_.Update(OfScene(scene.model.scene(), status));
  }
  absl::Status status() const {
    const MutexLock lock(&mutex_);
    return status_;
  }

  const TorturePlan plan_;
  const std::stop_token stop_;
  absl::Time end_;
  TortureCounts counts_;
  std::vector<std::unique_ptr<TorturedScene>> scenes_;
  mutable Mutex mutex_;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // the first failure
};

}  // namespace

absl::StatusOr<TortureReport> RunTorture(const TorturePlan& plan,
                                         const std::vector<std::string>& scenes,
                                         const std::function<std::unique_ptr<Client>()>& new_client,
                                         const std::function<void(const std::string&)>& show,
                                         const std::stop_token& stop) {
  TortureRun torture(plan, stop);
  for (const std::string& scene : scenes) {
    LATTICED_RETURN_IF_ERROR(torture.Open(scene, new_client()));
  }
  const absl::Time begin = absl::Now();
  LATTICED_RETURN_IF_ERROR(torture.Run(show));
  TortureReport report = torture.Report();
  report.duration = absl::Now() - begin;
  return report;
}

}  // namespace latticed::client
