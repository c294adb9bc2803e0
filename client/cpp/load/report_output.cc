// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/report_output.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <utility>
#include <vector>

#include "client/cpp/latticectl/text_table.h"
#include "client/cpp/latticectl/view_flags.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr double kGigabyte = 1e9;

using Row = std::vector<std::string>;

double PerSecond(uint64_t count, const LoadReport& report) {
  return static_cast<double>(count) / absl::ToDoubleSeconds(report.duration);
}

// None where no chunk has changed.
std::optional<double> PerGigabyte(absl::Duration cpu, const LoadReport& report) {
  if (report.bytes() == 0) return std::nullopt;
  return absl::ToDoubleSeconds(cpu) * kGigabyte / static_cast<double>(report.bytes());
}

const char* MovedText(const LoadPlan& plan) {
  return plan.all_points ? "every second control point" : "one control point";
}

std::string CountedIfAny(uint64_t count, const char* what) {
  return count == 0 ? "" : fmt::format(", {} {}", FormatCount(count), what);
}

struct NamedGroup {
  const char* name;
  const StreamGroup& group;
};

std::vector<NamedGroup> Groups(const LoadReport& report) {
  std::vector<NamedGroup> groups{{"editors", report.editors}};
  if (report.watchers.streams > 0) groups.push_back({"watchers", report.watchers});
  if (report.slow.streams > 0) groups.push_back({"slow watchers", report.slow});
  return groups;
}

struct NamedLatency {
  std::string key, name;
  const LatencyRecorder& recorder;
};

std::vector<NamedLatency> Latencies(const StreamGroup& group) {
  return {{"firstChunk", "edit to first chunk", group.first_chunk},
          {"updateEnd", "edit to update end", group.update_end},
          {"decoded", "edit to decoded", group.decoded}};
}

std::vector<NamedLatency> Stages(const ServerStages& stages) {
  return {{"arrivalToBytes", "server: edit's arrival to all bytes", stages.arrival_to_bytes},
          {"apply", "server: edit's arrival to applied", stages.apply},
          {"queue", "server: applied to update begin", stages.queue},
          {"evaluate", "server: evaluate", stages.evaluate},
          {"encode", "server: encode", stages.encode},
          {"send", "server: update begin to end", stages.send}};
}

Row LatencyHeader() { return {"", "P50 MS", "P90 MS", "P99 MS", "MAX MS", "COUNT"}; }

std::vector<Row> LatencyRows(const LoadReport& report) {
  std::vector<Row> rows;
  const auto add = [&rows](const std::string& name, const LatencyRecorder& recorder) {
    if (recorder.count() == 0) return;
    const LatencySummary summary = recorder.Summarise();
    const auto text = [](double ms) { return fmt::format("{:.2f}", ms); };
    rows.push_back({name, text(summary.p50), text(summary.p90), text(summary.p99),
                    text(summary.max), FormatCount(summary.count)});
  };
  for (const auto& [name, group] : Groups(report)) {
    for (const auto& latency : Latencies(group)) {
      add(fmt::format("{}: {}", name, latency.name), latency.recorder);
    }
  }
  for (const auto& stage : Stages(report.stages)) add(stage.name, stage.recorder);
  return rows;
}

std::string CpuText(const LoadReport& report) {
  const CpuTimes& cpu = report.cpu;
  const auto text = [&report](const char* whose, absl::Duration time) {
    const auto per_gigabyte = PerGigabyte(time, report);
    return fmt::format("{} {:.2f} s{}", whose, absl::ToDoubleSeconds(time),
                       per_gigabyte ? fmt::format(", {:.2f} s/GB", *per_gigabyte) : "");
  };
  if (cpu.own_holds_server) return text("client and server in one process", cpu.own);
  std::string result = text("client", cpu.own);
  if (cpu.server.has_value()) result += "; " + text("server", *cpu.server);
  return result;
}

std::vector<Row> TimeRows(const LoadReport& report) {
  const std::vector<TimeShare> shares = TimeShares(report);
  if (shares.empty()) return {};
  std::string text;
  double sum = 0;
  for (const auto& [key, name, ms] : shares) {
    text += fmt::format("{} {:.2f} ms, ", name, ms);
    sum += ms;
  }
  const TimeShare& longest = shares.front();
  return {{"where the time goes", text + "the median of each"},
          {"next bottleneck", fmt::format("{}, {:.0f} % of these {:.2f} ms", longest.name,
                                          sum > 0 ? 100 * longest.ms / sum : 0, sum)}};
}

std::vector<Row> FactRows(const LoadReport& report) {
  std::vector<Row> rows{
      {"edits", fmt::format("{} in {:.2f} s, {:.1f}/s; {} replaced before they were sent{}",
                            FormatCount(report.edits), absl::ToDoubleSeconds(report.duration),
                            PerSecond(report.edits, report), FormatCount(report.replaced),
                            CountedIfAny(report.unsent, "due and not sent when it was stopped"))}};
  for (const auto& [name, group] : Groups(report)) {
    const SentChunks chunks = group.MedianChunks();
    rows.push_back(
        {fmt::format("{} ({})", name, group.streams),
         fmt::format("{} updates, {:.1f}/s; {:.1f} MB/s; {} of {} chunks in the median update; {} "
                     "edits merged, {} updates restarted{}",
                     FormatCount(group.updates), PerSecond(group.updates, report),
                     PerSecond(group.bytes, report) / 1e6, FormatCount(chunks.sent),
                     FormatCount(chunks.all), FormatCount(group.merged),
                     FormatCount(group.restarted),
                     CountedIfAny(group.unseen, "edits not seen yet"))});
  }
  rows.push_back({"server", fmt::format("{} updates superseded by one in less detail",
                                        FormatCount(report.superseded))});
  for (Row& row : TimeRows(report)) rows.push_back(std::move(row));
  rows.push_back({"processor", CpuText(report)});
  rows.push_back(
      {"verified",
       fmt::format("{} updates at their own revisions, {} points and {} normals of them against "
                   "EvaluatePoints; the worst are off by {:.2f} and {:.2f} of what is allowed",
                   FormatCount(report.verified.updates), FormatCount(report.verified.positions),
                   FormatCount(report.verified.normals), report.verified.worst_position,
                   report.verified.worst_normal)});
  return rows;
}

nlohmann::json ToJson(const LatencyRecorder& recorder) {
  const LatencySummary summary = recorder.Summarise();
  return {{"count", summary.count},
          {"p50Ms", summary.p50},
          {"p90Ms", summary.p90},
          {"p99Ms", summary.p99},
          {"maxMs", summary.max}};
}

nlohmann::json ToJson(const StreamGroup& group, const LoadReport& report) {
  const SentChunks chunks = group.MedianChunks();
  nlohmann::json json{{"streams", group.streams},
                      {"updates", group.updates},
                      {"updatesPerSecond", PerSecond(group.updates, report)},
                      {"bytes", group.bytes},
                      {"bytesPerSecond", PerSecond(group.bytes, report)},
                      {"medianUpdate", {{"chunks", chunks.sent}, {"allChunks", chunks.all}}},
                      {"editsMerged", group.merged},
                      {"updatesRestarted", group.restarted},
                      {"editsUnseen", group.unseen}};
  for (const auto& latency : Latencies(group)) json[latency.key] = ToJson(latency.recorder);
  return json;
}

nlohmann::json CpuJson(const LoadReport& report) {
  const auto time = [&report](absl::Duration cpu) {
    nlohmann::json json{{"seconds", absl::ToDoubleSeconds(cpu)}};
    const auto per_gigabyte = PerGigabyte(cpu, report);
    if (per_gigabyte.has_value()) json["secondsPerGigabyte"] = *per_gigabyte;
    return json;
  };
  nlohmann::json json{
      {report.cpu.own_holds_server ? "clientAndServer" : "client", time(report.cpu.own)}};
  if (report.cpu.server.has_value()) json["server"] = time(*report.cpu.server);
  return json;
}

std::string Counted(int count, const char* one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

// "2 scenes of knot, 1 editor and 20 watchers each, …".
std::string LoadTitle(const LoadPlan& plan, const LoadReport& report) {
  std::string title = fmt::format(
      "{} of {}, {} patches, {} points in all; {}", Counted(plan.scenes, "scene"), report.meshes,
      FormatCount(report.patches), FormatCount(report.points), Counted(plan.editors, "editor"));
  if (plan.watchers > 0) title += ", " + Counted(plan.watchers, "watcher");
  if (plan.slow > 0) {
    title += fmt::format(", {} slow ({:g} MB/s)", plan.slow, plan.slow_rate / 1e6);
  }
  if (plan.stalled > 0) title += fmt::format(", {} stalled", plan.stalled);
  return title + fmt::format("{}; {}; {} moved, {}", plan.scenes > 1 ? " each" : "",
                             LoadModeText(plan), MovedText(plan), EncodingName(report.encoding));
}

std::string MarkdownRow(const Row& row) {
  std::string text = "|";
  for (const std::string& cell : row) text += " " + cell + " |";
  return text + "\n";
}

}  // namespace

void PrintLoadText(const LoadPlan& plan, const LoadReport& report, std::ostream& out) {
  out << LoadTitle(plan, report) << "\n\n";
  TextTable latencies(LatencyHeader());
  for (Row& row : LatencyRows(report)) latencies.AddRow(std::move(row));
  latencies.Print(out);
  out << '\n';
  TextTable facts;
  for (Row& row : FactRows(report)) facts.AddRow(std::move(row));
  facts.Print(out);
}

std::string LoadMarkdown(const LoadPlan& plan, const LoadReport& report) {
  std::string text = fmt::format("## {}\n\n{}|---|---:|---:|---:|---:|---:|\n",
                                 LoadTitle(plan, report), MarkdownRow(LatencyHeader()));
  for (const Row& row : LatencyRows(report)) text += MarkdownRow(row);
  text += '\n';
  for (const Row& row : FactRows(report)) text += fmt::format("* {}: {}\n", row[0], row[1]);
  return text + '\n';
}

void PrintLoadJson(const LoadPlan& plan, const LoadReport& report, std::ostream& out) {
  nlohmann::json json{{"meshes", report.meshes},
                      {"scenes", plan.scenes},
                      {"stalled", plan.scenes * plan.stalled},
                      {"patches", report.patches},
                      {"points", report.points},
                      {"encoding", EncodingName(report.encoding)},
                      {"pace", LoadModeText(plan)},
                      {"moved", MovedText(plan)},
                      {"edits", report.edits},
                      {"editsReplaced", report.replaced},
                      {"editsUnsent", report.unsent},
                      {"seconds", absl::ToDoubleSeconds(report.duration)},
                      {"updatesPerSecond", PerSecond(report.updates(), report)},
                      {"bytesPerSecond", PerSecond(report.bytes(), report)},
                      {"editors", ToJson(report.editors, report)},
                      {"watchers", ToJson(report.watchers, report)},
                      {"slow", ToJson(report.slow, report)},
                      {"cpu", CpuJson(report)},
                      {"verified",
                       {{"updates", report.verified.updates},
                        {"points", report.verified.positions},
                        {"normals", report.verified.normals},
                        {"worstPosition", report.verified.worst_position},
                        {"worstNormal", report.verified.worst_normal}}}};
  const auto shares = TimeShares(report);
  for (const TimeShare& share : shares) json["timeGoesMs"][share.key] = share.ms;
  if (!shares.empty()) json["bottleneck"] = shares.front().key;
  for (const auto& stage : Stages(report.stages))
    json["server"][stage.key] = ToJson(stage.recorder);
  json["server"]["updatesSuperseded"] = report.superseded;
  out << json.dump(2) << '\n';
}

}  // namespace latticed::client
