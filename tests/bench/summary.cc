// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/summary.h"

#include <algorithm>

#include "fmt/format.h"

namespace latticed::bench {
namespace {

constexpr char kSmall[] = "evaluate/torus-17k/";
constexpr char kFusedLane[] = "fused/degree2/lane-order/facet/10segments/1t";
constexpr char kFusedStreamed[] = "fused/degree2/quantised/facet/10segments/1t";
constexpr char kGemm[] = "gemm/degree2/point-order/facet/10segments/1t";

// `numerator` over `denominator`, or `numerator` alone: a benchmark's time in milliseconds, or
// "benchmark:counter".
struct Target {
  std::string text;
  std::string numerator, denominator;
  bool at_least = true;
  double target = 0;
};

std::vector<Target> Targets() {
  const std::string s = kSmall;
  return {
      {"gemm / fused, lane order", s + kGemm, s + kFusedLane, true, 12},
      {"blocked product alone / fused, lane order", "floor/blocked-product-alone/1t",
       s + kFusedLane, true, 2},
      {"fused, lane order / streaming stores", s + kFusedLane, "floor/streaming-stores/1t", false,
       3},
      {"gemm / fused as streamed (12/8 bits)", s + kGemm, s + kFusedStreamed, true, 9},
      {"fused as streamed, ms", s + kFusedStreamed, "", false, 4.5},
      {"fused, one thread / two", s + kFusedLane,
       s + "fused/degree2/lane-order/facet/10segments/2t", true, 1.7},
      {"fused as streamed, one thread / two", s + kFusedStreamed,
       s + "fused/degree2/quantised/facet/10segments/2t", true, 1.7},
      {"smooth / facet normals", s + "fused/degree2/lane-order/smooth/10segments/1t",
       s + kFusedLane, false, 1.8},
      {"delivery of raw chunks on one stream, GB/s", "delivery/raw-chunks:GB_s", "", true, 2},
      {"plan of 100,000 faces, ms", "plan/100000-faces", "", false, 500},
      {"plan, 100,000 faces / 25,000", "plan/100000-faces", "plan/25000-faces", false, 4.8},
  };
}

// Google Benchmark appends its settings and the aggregate's name to a benchmark's own.
std::string OwnName(const benchmark::BenchmarkReporter::Run& run) {
  return run.run_name.function_name;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

bool SummaryReporter::ReportContext(const Context& context) {
  PrintBasicContext(&GetErrorStream(), context);
  GetOutputStream() << fmt::format("{:<64}{:>12}{:>12}\n", "benchmark", "median ms", "least ms");
  return true;
}

void SummaryReporter::ReportRuns(const std::vector<Run>& reports) {
  std::vector<double> times;
  for (const Run& run : reports) {
    if (run.error_occurred) {
      failed_ = true;
      GetOutputStream() << fmt::format("{:<64}  WRONG: {}\n", OwnName(run), run.error_message);
      return;
    }
    if (run.run_type == Run::RT_Iteration) times.push_back(run.GetAdjustedRealTime());
  }
  if (times.empty()) return;
  const Run& run = reports.front();
  values_[OwnName(run)] = Median(times);
  std::string line = fmt::format("{:<64}{:>12.3f}{:>12.3f}", OwnName(run), Median(times),
                                 *std::min_element(times.begin(), times.end()));
  for (const auto& [name, counter] : run.counters) {
    values_[OwnName(run) + ":" + name] = counter.value;
    line += fmt::format("  {}={:.4g}", name, counter.value);
  }
  GetOutputStream() << line << std::endl;
}

void SummaryReporter::PrintTargets() const {
  auto& out = GetOutputStream();
  out << fmt::format("\n{:<46}{:>10}{:>12}\n", "ratio in this run", "measured", "target");
  for (const Target& t : Targets()) {
    const auto numerator = values_.find(t.numerator);
    const auto denominator = values_.find(t.denominator);
    if (numerator == values_.end()) continue;
    if (!t.denominator.empty() && denominator == values_.end()) continue;
    const double value =
        t.denominator.empty() ? numerator->second : numerator->second / denominator->second;
    const bool met = t.at_least ? value >= t.target : value <= t.target;
    out << fmt::format("{:<46}{:>10.2f}{:>4}{:>8.1f}  {}\n", t.text, value,
                       t.at_least ? ">=" : "<=", t.target, met ? "met" : "missed");
  }
}

}  // namespace latticed::bench
