// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_run.h"

#include <time.h>

#include <thread>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "client/cpp/library/status.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr absl::Duration kProgressInterval = absl::Milliseconds(100);
// Between the last thread's start and the first edit.
constexpr absl::Duration kStartDelay = absl::Milliseconds(20);

// Processor time, user and system together.
absl::Duration OwnCpuTime() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return absl::DurationFromTimespec(time);
}

absl::StatusOr<absl::Duration> CpuTimeOf(int process) {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) {
    return absl::NotFoundError(fmt::format("there is no process {} here", process));
  }
  return absl::DurationFromTimespec(time);
}

}  // namespace

LoadRun::LoadRun(const LoadPlan& plan, const std::vector<LoadScene>& scenes,
                 const SceneLoad::NewClient& new_client, const Options& options,
                 const std::stop_token& stop)
    : plan_(plan), options_(options), client_(new_client()), control_(stop) {
  for (const LoadScene& scene : scenes) {
    scenes_.push_back(std::make_unique<SceneLoad>(&plan_, scene, new_client, &control_));
  }
}

absl::StatusOr<LoadReport> LoadRun::Run(const Progress& progress) {
  LATTICED_RETURN_IF_ERROR(Prepare());
  LATTICED_ASSIGN_OR_RETURN(const auto before, ReadCounters());
  const absl::Time begin = absl::Now();
  Measure(progress);
  absl::Status status = Settle();
  LoadReport report;
  report.duration = absl::Now() - begin;
  const auto after = ReadCounters();
  for (const auto& scene : scenes_) scene->Close();
  LATTICED_RETURN_IF_ERROR(status);
  LATTICED_RETURN_IF_ERROR(after.status());
  for (const auto& scene : scenes_) {
    LATTICED_RETURN_IF_ERROR(scene->Verify(options_.fused));
    scene->AddTo(&report);
  }
  if (report.edits == 0) return Stopped();
  report.superseded = after->superseded - before.superseded;
  report.cpu = after->cpu;
  report.cpu.own -= before.cpu.own;
  if (report.cpu.server.has_value()) *report.cpu.server -= *before.cpu.server;
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
  const bool timed = plan_.timed();
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

absl::StatusOr<LoadRun::Counters> LoadRun::ReadCounters() const {
  LATTICED_ASSIGN_OR_RETURN(const auto info, client_->GetServerInfo());
  Counters counters{.cpu = {.own = OwnCpuTime(), .own_holds_server = options_.server_inside},
                    .superseded = info.superseded_updates()};
  if (options_.server_process == 0) return counters;
  LATTICED_ASSIGN_OR_RETURN(counters.cpu.server, CpuTimeOf(options_.server_process));
  return counters;
}

}  // namespace latticed::client
