// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_run.h"

#include <thread>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "client/cpp/library/status.h"
#include "client/cpp/load/cpu_time.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

constexpr absl::Duration kProgressInterval = absl::Milliseconds(100);
// Between the last thread's start and the first edit.
constexpr absl::Duration kStartDelay = absl::Milliseconds(20);

}  // namespace

LoadRun::LoadRun(const LoadPlan& plan, const std::vector<LoadScene>& scenes,
                 const SceneLoad::NewClient& new_client, const Options& options,
                 const std::stop_token& stop)
    : plan_(plan), options_(options), control_(stop) {
  for (const LoadScene& scene : scenes) {
    scenes_.push_back(std::make_unique<SceneLoad>(&plan_, scene, new_client, &control_));
  }
}

absl::StatusOr<LoadReport> LoadRun::Run(const Progress& progress) {
  LATTICED_RETURN_IF_ERROR(Prepare());
  LATTICED_ASSIGN_OR_RETURN(const auto cpu_before, ReadCpuTimes());
  const std::optional<uint64_t> superseded_before = options_.superseded();
  const absl::Time begin = absl::Now();
  Measure(progress);
  absl::Status status = Settle();
  LoadReport report;
  report.duration = absl::Now() - begin;
  report.superseded = options_.superseded();
  auto cpu = ReadCpuTimes();
  for (const auto& scene : scenes_) scene->Close();
  if (!status.ok()) return status;
  if (!cpu.ok()) return cpu.status();
  for (const auto& scene : scenes_) {
    if (status = scene->Verify(options_.fused); !status.ok()) return status;
    scene->AddTo(&report);
  }
  if (report.edits == 0) return Stopped();
  if (report.superseded.has_value()) *report.superseded -= superseded_before.value_or(0);
  report.cpu = *cpu;
  report.cpu.own -= cpu_before.own;
  if (report.cpu.server.has_value()) *report.cpu.server -= *cpu_before.server;
  return report;
}

absl::Status LoadRun::Prepare() {
  for (const auto& scene : scenes_) {
    LATTICED_RETURN_IF_ERROR(scene->Open());
  }
  for (const auto& scene : scenes_) {
    LATTICED_RETURN_IF_ERROR(scene->WarmUp());
  }
  return control_.Ended() ? Stopped() : absl::OkStatus();
}

void LoadRun::Measure(const Progress& progress) {
  const absl::Time begin = absl::Now() + kStartDelay;
  control_.Begin(begin + plan_.duration);
  for (const auto& scene : scenes_) scene->Start(begin);
  absl::Notification done;
  std::thread waiter([&] {
    for (const auto& scene : scenes_) scene->WaitUntilDone();
    done.Notify();
  });
  const bool timed = plan_.duration < absl::InfiniteDuration();
  const uint64_t all = timed ? static_cast<uint64_t>(absl::ToInt64Milliseconds(plan_.duration))
                             : plan_.edits * static_cast<uint64_t>(plan_.editors) * scenes_.size();
  do {
    const int64_t passed = std::max<int64_t>(0, absl::ToInt64Milliseconds(absl::Now() - begin));
    progress(timed ? static_cast<uint64_t>(passed) : control_.edits(), all);
  } while (!done.WaitForNotificationWithTimeout(kProgressInterval));
  waiter.join();
}

absl::Status LoadRun::Settle() {
  for (const auto& scene : scenes_) {
    LATTICED_RETURN_IF_ERROR(control_.status());
    LATTICED_RETURN_IF_ERROR(scene->Settle());
  }
  return control_.status();
}

absl::StatusOr<CpuTimes> LoadRun::ReadCpuTimes() const {
  CpuTimes times{.own = OwnCpuTime(), .own_holds_server = options_.server_inside};
  if (options_.server_process == 0) return times;
  LATTICED_ASSIGN_OR_RETURN(const auto server, CpuTimeOf(options_.server_process));
  times.server = server;
  return times;
}

}  // namespace latticed::client
