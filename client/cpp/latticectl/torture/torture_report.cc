// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/torture/torture_report.h"

#include <nlohmann/json.hpp>

#include "client/cpp/latticectl/output/output.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

std::string Text(const LatencySummary& latency) {
  return fmt::format("p50 {}, p99 {}, longest {}", FormatMilliseconds(latency.p50),
                     FormatMilliseconds(latency.p99), FormatMilliseconds(latency.max));
}

nlohmann::json Json(const LatencySummary& latency) {
  return {{"count", latency.count},
          {"p50Ms", latency.p50},
          {"p99Ms", latency.p99},
          {"maxMs", latency.max}};
}

}  // namespace

void Faults::Add(const Faults& other) {
  lost += other.lost;
  doubled += other.doubled;
  gaps += other.gaps;
  twice += other.twice;
  differing += other.differing;
  what.insert(what.end(), other.what.begin(), other.what.end());
}

std::string TortureText(const TortureReport& report) {
  const Faults& faults = report.faults;
  TextTable table;
  const auto count = [&table](const char* name, uint64_t value) {
    table.AddRow({name, FormatCount(value)});
  };
  count("acknowledged", report.acknowledged);
  count("lost", faults.lost);
  count("doubled", faults.doubled);
  count("gaps", faults.gaps);
  count("acknowledged twice", faults.twice);
  count("lattices that differ", faults.differing);
  table.AddRow({"lattices compared",
                fmt::format("{}, also after the last edit", FormatCount(report.checks))});
  table.AddRow({"refused", fmt::format("{}, and {} put off by the server",
                                       FormatCount(report.refused), FormatCount(report.put_off))});
  count("reconnections", report.reconnections);
  table.AddRow({"edit to acknowledgement", Text(report.answers)});
  if (report.pauses.count > 0) {
    table.AddRow({fmt::format("pauses above {}", absl::FormatDuration(kPause)),
                  fmt::format("{}: {}; the longest in scene {}", FormatCount(report.pauses.count),
                              Text(report.pauses), report.longest_pause)});
  }
  table.AddRow({"seed", std::to_string(report.seed)});
  std::string text = table.Text();
  for (const std::string& what : faults.what) text += what + '\n';
  return text;
}

nlohmann::json TortureJson(const TortureReport& report) {
  const Faults& faults = report.faults;
  return {{"acknowledged", report.acknowledged},
          {"lost", faults.lost},
          {"doubled", faults.doubled},
          {"gaps", faults.gaps},
          {"acknowledgedTwice", faults.twice},
          {"differing", faults.differing},
          {"faults", faults.what},
          {"compared", report.checks},
          {"refused", report.refused},
          {"putOff", report.put_off},
          {"reconnections", report.reconnections},
          {"seconds", absl::ToDoubleSeconds(report.duration)},
          {"seed", report.seed},
          {"answers", Json(report.answers)},
          {"pauses", Json(report.pauses)}};
}

void TortureCounts::Acknowledged(const std::string& scene, absl::Duration took) {
  const MutexLock lock(&mutex_);
  ++report_.acknowledged;
  answers_.Add(took);
  if (took > kPause) pauses_.Add(took);
  if (took <= longest_) return;
  longest_ = took;
  report_.longest_pause = scene;
}

void TortureCounts::Refused(bool put_off) {
  const MutexLock lock(&mutex_);
  ++(put_off ? report_.put_off : report_.refused);
}

void TortureCounts::Checked() {
  const MutexLock lock(&mutex_);
  ++report_.checks;
}

void TortureCounts::Reconnected(int times) {
  const MutexLock lock(&mutex_);
  report_.reconnections += static_cast<uint64_t>(times);
}

TortureReport TortureCounts::Report() const {
  const MutexLock lock(&mutex_);
  TortureReport report = report_;
  report.answers = answers_.Summarise();
  report.pauses = pauses_.Summarise();
  return report;
}

std::string TortureCounts::Line() const {
  const MutexLock lock(&mutex_);
  return fmt::format("{} edits acknowledged, longest pause {}, {} reconnections",
                     FormatCount(report_.acknowledged),
                     FormatMilliseconds(absl::ToDoubleMilliseconds(longest_)),
                     FormatCount(report_.reconnections));
}

}  // namespace latticed::client
