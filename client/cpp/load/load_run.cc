// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_run.h"

#include <time.h>

#include <utility>

#include "absl/time/clock.h"
#include "client/cpp/latticectl/session/scene_tolerance.h"
#include "client/cpp/library/status.h"
#include "client/cpp/load/load_control.h"
#include "client/cpp/load/load_edit.h"
#include "client/cpp/load/load_stream.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

using Kind = LoadStream::Kind;

// Time for all threads to start before the first edit is due.
constexpr absl::Duration kStartDelay = absl::Milliseconds(20);
constexpr uint64_t kWarmUpEdits = 4;  // an even number returns all points to their places

// Processor time of a process, user plus system. Process 0 is this one.
absl::StatusOr<absl::Duration> CpuTimeOf(int process) {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) {
    return absl::NotFoundError(fmt::format("there is no process {} here", process));
  }
  return absl::DurationFromTimespec(time);
}

// Adds the scene to the error's message. Keeps its details.
absl::Status About(const std::string& scene, const absl::Status& status) {
  if (status.ok()) return status;
  return error::WithDetails(absl::Status(status.code(), fmt::format("scene {}: {}", scene,
                                                                    std::string(status.message()))),
                            error::DetailsOf(status));
}

// The load on one scene: Open -> WarmUp -> Start -> WaitUntilEdited -> Settle -> Close -> AddTo.
class SceneLoad {
 public:
  SceneLoad(std::string scene, std::unique_ptr<Client> client)
      : scene_(std::move(scene)), client_(std::move(client)) {}

  absl::Status Open(const LoadPlan& plan, const NewClient& new_client, LoadControl* control) {
    LATTICED_ASSIGN_OR_RETURN(lattice_, client_->GetLattice(scene_));
    v1::ViewOptions view = plan.view;
    LATTICED_RETURN_IF_ERROR(SetTolerance(*client_, scene_, plan.tolerance, &view));
    const std::pair<Kind, int> kinds[] = {{Kind::kEditor, plan.editors},
                                          {Kind::kWatcher, plan.watchers},
                                          {Kind::kSlow, plan.slow},
                                          {Kind::kStalled, plan.stalled}};
    for (const auto& [kind, count] : kinds) {
      for (int i = 0; i < count && !control->Ended(); ++i) {
        LATTICED_ASSIGN_OR_RETURN(auto stream, LoadStream::Open(new_client(), kind, i,
                                                                {.plan = &plan,
                                                                 .control = control,
                                                                 .scene = scene_,
                                                                 .view = view,
                                                                 .lattice = &lattice_,
                                                                 .edits = &edits_}));
        streams_.push_back(std::move(stream));
      }
    }
    return absl::OkStatus();
  }

  // Makes a few edits that are not measured, and waits until all streams that keep up have seen each.
  absl::Status WarmUp(const LoadControl& control) {
    const std::string editor = RandomEditorId();
    for (uint64_t step = 0; step < kWarmUpEdits && !control.Ended(); ++step) {
      v1::EditBatch batch = MakeLoadEdit(lattice_, /*all_points=*/true, step);
      batch.set_scene(scene_);
      batch.set_editor_id(editor);
      batch.set_sequence(step + 1);
      LATTICED_ASSIGN_OR_RETURN(const auto result, client_->ApplyEdits(batch));
      first_revision_ = result.revision();
      LATTICED_RETURN_IF_ERROR(WaitForAll(first_revision_));
    }
    return absl::OkStatus();
  }

  void Start(absl::Time begin) {
    for (const auto& stream : streams_) stream->Start(begin);
  }

  void WaitUntilEdited() {
    for (const auto& stream : streams_) stream->WaitUntilEdited();
  }

  // Waits until all streams that keep up have received the last revision.
  absl::Status Settle() {
    LATTICED_ASSIGN_OR_RETURN(const auto scene, client_->GetScene(scene_));
    return WaitForAll(scene.revision());
  }

  void Close() {
    for (const auto& stream : streams_) stream->Close();
  }

  // Verifies a few chunks of each stream that keeps up, and adds this scene to the report.
  absl::Status AddTo(LoadReport* report) {
    SurfaceVerifier verifier(client_.get(), scene_);
    edits_.Sort();
    report->edits += edits_.edits().size();
    report->replaced += edits_.edits().size() - edits_.batches().size();
    size_t offset = 0;
    for (const auto& stream : streams_) {
      if (stream->keeps_up()) {
        LATTICED_RETURN_IF_ERROR(verifier.Check(stream->surface(), offset++, &report->verified));
      }
      if (stream->kind() == Kind::kStalled) continue;
      StreamGroup& group = stream->kind() == Kind::kEditor    ? report->editors
                           : stream->kind() == Kind::kWatcher ? report->watchers
                                                              : report->slow;
      group.Add(stream->log(), edits_.edits(), first_revision_);
    }
    const LoadStream& first = *streams_.front();
    report->stages.Add(first.log(), edits_.batches(), first_revision_);
    report->patches += first.surface().topology().patch_count();
    report->points += first.surface().PointCount();
    report->encoding = first.surface().view().encoding();
    return absl::OkStatus();
  }

  const std::string& scene() const { return scene_; }

 private:
  absl::Status WaitForAll(uint64_t revision) const {
    absl::Status status;
    for (const auto& stream : streams_) {
      if (stream->keeps_up()) status.Update(stream->WaitFor(revision));
    }
    return status;
  }

  const std::string scene_;
  const std::unique_ptr<Client> client_;  // for unary calls
  v1::LatticeState lattice_;
  uint64_t first_revision_ = 0;  // the revision before the measured edits
  EditLog edits_;
  std::vector<std::unique_ptr<LoadStream>> streams_;  // last member: they use the others
};

absl::StatusOr<LoadCounters> ReadCounters(Client& client, const LoadProcesses& processes) {
  LoadCounters counters;
  LATTICED_ASSIGN_OR_RETURN(const auto info, client.GetServerInfo());
  counters.superseded = info.superseded_updates();
  LATTICED_ASSIGN_OR_RETURN(counters.own_cpu, CpuTimeOf(/*process=*/0));
  if (processes.server == 0) return counters;
  LATTICED_ASSIGN_OR_RETURN(counters.server_cpu, CpuTimeOf(processes.server));
  return counters;
}

}  // namespace

absl::StatusOr<LoadReport> RunLoad(const LoadPlan& plan, const std::vector<std::string>& scenes,
                                   const NewClient& new_client, const LoadProcesses& processes,
                                   const Progress& progress, const std::stop_token& stop) {
  const bool timed = plan.duration < absl::InfiniteDuration();
  LoadControl control(stop, progress,
                      timed ? 0 : plan.edits * static_cast<uint64_t>(plan.editors) * scenes.size());
  std::vector<std::unique_ptr<SceneLoad>> loads;
  loads.reserve(scenes.size());
  for (const std::string& scene : scenes) {
    loads.push_back(std::make_unique<SceneLoad>(scene, new_client()));
  }
  const auto for_each = [&loads](const auto& act) {
    for (const auto& load : loads) {
      LATTICED_RETURN_IF_ERROR(About(load->scene(), act(*load)));
    }
    return absl::OkStatus();
  };
  LATTICED_RETURN_IF_ERROR(
      for_each([&](SceneLoad& load) { return load.Open(plan, new_client, &control); }));
  LATTICED_RETURN_IF_ERROR(for_each([&](SceneLoad& load) { return load.WarmUp(control); }));
  if (control.Ended()) return Stopped();

  const auto client = new_client();
  LoadReport report{.own_holds_server = processes.own_holds_server};
  LATTICED_ASSIGN_OR_RETURN(report.before, ReadCounters(*client, processes));
  const absl::Time begin = absl::Now() + kStartDelay;
  control.Begin(begin + plan.duration);
  for (const auto& load : loads) load->Start(begin);
  for (const auto& load : loads) load->WaitUntilEdited();
  LATTICED_RETURN_IF_ERROR(control.status());
  LATTICED_RETURN_IF_ERROR(for_each([](SceneLoad& load) { return load.Settle(); }));
  LATTICED_RETURN_IF_ERROR(control.status());
  report.duration = absl::Now() - begin;
  LATTICED_ASSIGN_OR_RETURN(report.after, ReadCounters(*client, processes));
  for (const auto& load : loads) load->Close();
  LATTICED_RETURN_IF_ERROR(for_each([&](SceneLoad& load) { return load.AddTo(&report); }));
  if (report.edits == 0) return Stopped();
  return report;
}

}  // namespace latticed::client
