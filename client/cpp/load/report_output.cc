// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/report_output.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/output/output.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr double kGigabyte = 1e9;

double PerSecond(uint64_t count, const LoadReport& report) {
  return static_cast<double>(count) / absl::ToDoubleSeconds(report.duration);
}

const char* MovedText(const LoadPlan& plan) {
  return plan.all_points ? "every second control point" : "one control point";
}

std::string PaceText(const LoadPlan& plan) {
  switch (plan.mode) {
    case LoadMode::kClosed:
      return "closed loop";
    case LoadMode::kOpen:
      return fmt::format("open loop, {:g} edits/s an editor",
                         1 / absl::ToDoubleSeconds(plan.period));
    case LoadMode::kInterval:
      return fmt::format("an edit every {:g} ms, the newest replaces what waits",
                         absl::ToDoubleMilliseconds(plan.period));
  }
  return "";
}

struct NamedGroup {
  const char *key, *name;
  const StreamGroup& group;
};

std::vector<NamedGroup> Groups(const LoadReport& report) {
  return {{"editors", "editors", report.editors},
          {"watchers", "watchers", report.watchers},
          {"slow", "slow watchers", report.slow}};
}

struct NamedLatency {
  const char *key, *name;
  const LatencyRecorder& recorder;
};

std::vector<NamedLatency> Latencies(const StreamGroup& group) {
  return {{"firstChunk", "edit to first chunk", group.first_chunk},
          {"updateEnd", "edit to update end", group.update_end},
          {"decoded", "edit to decoded", group.decoded}};
}

std::vector<NamedLatency> Stages(const ServerStages& stages) {
  return {{"arrivalToBytes", "edit's arrival to all bytes", stages.arrival_to_bytes},
          {"apply", "edit's arrival to applied", stages.apply},
          {"queue", "applied to update begin", stages.queue},
          {"evaluate", "evaluate", stages.evaluate},
          {"encode", "encode", stages.encode},
          {"send", "update begin to end", stages.send}};
}

struct CpuTime {
  const char *key, *name;
  absl::Duration time;
  double per_gigabyte = 0;  // seconds; 0 where no chunk has changed
};

std::vector<CpuTime> CpuTimes(const LoadReport& report) {
  const absl::Duration own = report.after.own_cpu - report.before.own_cpu;
  std::vector<CpuTime> times{report.own_holds_server
                                 ? CpuTime{"clientAndServer", "client and server", own}
                                 : CpuTime{"client", "client", own}};
  if (report.after.server_cpu.has_value()) {
    times.push_back({"server", "server", *report.after.server_cpu - *report.before.server_cpu});
  }
  for (CpuTime& time : times) {
    if (report.bytes() == 0) continue;
    time.per_gigabyte =
        absl::ToDoubleSeconds(time.time) * kGigabyte / static_cast<double>(report.bytes());
  }
  return times;
}

std::string LatencyRows(const char* whose, const std::vector<NamedLatency>& latencies) {
  std::string rows;
  for (const auto& [key, name, recorder] : latencies) {
    if (recorder.count() == 0) continue;
    const LatencySummary summary = recorder.Summarise();
    rows += fmt::format("| {:<40} | {:7.2f} | {:7.2f} | {:7.2f} | {:7.2f} | {:>7} |\n",
                        fmt::format("{}: {}", whose, name), summary.p50, summary.p90, summary.p99,
                        summary.max, FormatCount(summary.count));
  }
  return rows;
}

std::string TimeText(const LoadReport& report) {
  const std::vector<TimeShare> shares = TimeShares(report);
  if (shares.empty()) return "";
  std::string text = "* where the time goes: ";
  double sum = 0;
  for (const auto& [key, name, ms] : shares) {
    text += fmt::format("{} {:.2f} ms, ", name, ms);
    sum += ms;
  }
  const TimeShare& longest = shares.front();
  return text +
         fmt::format("the median of each\n* next bottleneck: {}, {:.0f} % of these {:.2f} ms\n",
                     longest.name, sum > 0 ? 100 * longest.ms / sum : 0, sum);
}

std::string CpuText(const LoadReport& report) {
  std::string text = "* processor: ";
  for (const auto& [key, name, time, per_gigabyte] : CpuTimes(report)) {
    text += fmt::format("{} {:.2f} s", name, absl::ToDoubleSeconds(time));
    if (per_gigabyte > 0) text += fmt::format(" ({:.2f} s/GB)", per_gigabyte);
    text += ", ";
  }
  return text + "user and system\n";
}

std::string FactLines(const LoadReport& report) {
  std::string lines =
      fmt::format("* edits: {} in {:.2f} s, {:.1f}/s; {} replaced before they were sent\n",
                  FormatCount(report.edits), absl::ToDoubleSeconds(report.duration),
                  PerSecond(report.edits, report), FormatCount(report.replaced));
  for (const auto& [key, name, group] : Groups(report)) {
    if (group.streams == 0) continue;
    lines += fmt::format(
        "* {} ({}): {} updates, {:.1f}/s; {:.1f} MB/s; {} edits merged, {} updates restarted, {} "
        "edits not seen yet\n",
        name, group.streams, FormatCount(group.updates), PerSecond(group.updates, report),
        PerSecond(group.bytes, report) / 1e6, FormatCount(group.merged),
        FormatCount(group.restarted), FormatCount(group.unseen));
  }
  lines += fmt::format("* server: {} updates superseded by one in less detail\n",
                       FormatCount(report.after.superseded - report.before.superseded));
  if (!report.encoding_reason.empty()) {
    lines += fmt::format("* by {}: {}\n", EncodingName(report.encoding), report.encoding_reason);
  }
  lines += TimeText(report) + CpuText(report);
  return lines + fmt::format(
                     "* verified: {} points of {} against EvaluatePoints; the worst is off by "
                     "{:.2f} of the tolerance\n",
                     FormatCount(report.verified.points),
                     Counted(report.verified.surfaces, "stream"), report.verified.worst);
}

std::string CountedInt(int count, const char* one) {
  return Counted(static_cast<uint64_t>(count), one);
}

// "2 scenes of knot, 1 editor and 20 watchers each, …".
std::string LoadTitle(const LoadPlan& plan, const LoadReport& report) {
  std::string title = fmt::format(
      "{} of {}, {} patches, {} points in all; {}", CountedInt(plan.scenes, "scene"), report.meshes,
      FormatCount(report.patches), FormatCount(report.points), CountedInt(plan.editors, "editor"));
  if (plan.watchers > 0) title += ", " + CountedInt(plan.watchers, "watcher");
  if (plan.slow > 0) {
    title += fmt::format(", {} slow ({:g} MB/s)", plan.slow, plan.slow_rate / 1e6);
  }
  if (plan.stalled > 0) title += fmt::format(", {} stalled", plan.stalled);
  return title + fmt::format("{}; {}; {} moved, {}", plan.scenes > 1 ? " each" : "", PaceText(plan),
                             MovedText(plan), EncodingName(report.encoding));
}

nlohmann::json ToJson(const LatencyRecorder& recorder) {
  const LatencySummary summary = recorder.Summarise();
  return {{"count", summary.count},
          {"p50Ms", summary.p50},
          {"p90Ms", summary.p90},
          {"p99Ms", summary.p99},
          {"maxMs", summary.max}};
}

}  // namespace

std::string LoadMarkdown(const LoadPlan& plan, const LoadReport& report) {
  std::string text =
      fmt::format("## {}\n\n| {:<40} |  P50 MS |  P90 MS |  P99 MS |  MAX MS |   COUNT |\n",
                  LoadTitle(plan, report), "");
  text += "|---|---:|---:|---:|---:|---:|\n";
  for (const auto& [key, name, group] : Groups(report)) text += LatencyRows(name, Latencies(group));
  text += LatencyRows("server", Stages(report.stages));
  return text + '\n' + FactLines(report) + '\n';
}

nlohmann::json LoadJson(const LoadPlan& plan, const LoadReport& report) {
  nlohmann::json json{{"meshes", report.meshes},
                      {"scenes", plan.scenes},
                      {"stalled", plan.scenes * plan.stalled},
                      {"patches", report.patches},
                      {"points", report.points},
                      {"encoding", EncodingName(report.encoding)},
                      {"encodingReason", report.encoding_reason},
                      {"pace", PaceText(plan)},
                      {"moved", MovedText(plan)},
                      {"edits", report.edits},
                      {"editsReplaced", report.replaced},
                      {"seconds", absl::ToDoubleSeconds(report.duration)},
                      {"updatesPerSecond", PerSecond(report.updates(), report)},
                      {"bytesPerSecond", PerSecond(report.bytes(), report)},
                      {"verified",
                       {{"streams", report.verified.surfaces},
                        {"points", report.verified.points},
                        {"worst", report.verified.worst}}}};
  for (const auto& [group_key, group_name, group] : Groups(report)) {
    nlohmann::json& of_group = json[group_key];
    of_group = {{"streams", group.streams},
                {"updates", group.updates},
                {"updatesPerSecond", PerSecond(group.updates, report)},
                {"bytes", group.bytes},
                {"bytesPerSecond", PerSecond(group.bytes, report)},
                {"editsMerged", group.merged},
                {"updatesRestarted", group.restarted},
                {"editsUnseen", group.unseen}};
    for (const auto& [key, name, recorder] : Latencies(group)) of_group[key] = ToJson(recorder);
  }
  for (const auto& [key, name, time, per_gigabyte] : CpuTimes(report)) {
    json["cpu"][key] = {{"seconds", absl::ToDoubleSeconds(time)}};
    if (per_gigabyte > 0) json["cpu"][key]["secondsPerGigabyte"] = per_gigabyte;
  }
  for (const TimeShare& share : TimeShares(report)) json["timeGoesMs"][share.key] = share.ms;
  for (const auto& [key, name, recorder] : Stages(report.stages)) {
    json["server"][key] = ToJson(recorder);
  }
  json["server"]["updatesSuperseded"] = report.after.superseded - report.before.superseded;
  return json;
}

}  // namespace latticed::client
