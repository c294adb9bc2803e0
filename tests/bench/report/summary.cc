// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/report/summary.h"

#include <algorithm>
#include <string_view>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/report/targets.h"

namespace latticed::bench {
namespace {

// The name without the settings and the aggregate's name, which Google Benchmark appends.
std::string OwnName(const benchmark::BenchmarkReporter::Run& run) {
  return run.run_name.function_name;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

SummaryReporter::SummaryReporter() {
  rows_.title = "Benchmarks";
  rows_.columns = {"benchmark", "median ms", "least ms", "counters"};
}

bool SummaryReporter::ReportContext(const Context& context) {
  PrintBasicContext(&GetErrorStream(), context);
  GetOutputStream() << fmt::format("{:<64}{:>12}{:>12}\n", "benchmark", "median ms", "least ms");
  return true;
}

void SummaryReporter::ReportError(const Run& run) {
  const std::string_view message = run.error_message;
  const bool missing = message.starts_with(kNotBuilt) || message.starts_with(kNotHere);
  const std::string text = missing ? std::string(message) : fmt::format("WRONG: {}", message);
  failed_ = failed_ || !missing;
  GetOutputStream() << fmt::format("{:<64}  {}", OwnName(run), text) << std::endl;
  rows_.rows.push_back({OwnName(run), "", "", text});
}

void SummaryReporter::ReportRuns(const std::vector<Run>& reports) {
  std::vector<double> times;
  for (const Run& run : reports) {
    if (run.error_occurred) return ReportError(run);
    if (run.run_type == Run::RT_Iteration) times.push_back(run.GetAdjustedRealTime());
  }
  if (times.empty()) return;
  const Run& run = reports.front();
  const double median = Median(times);
  double least = *std::min_element(times.begin(), times.end());
  std::string counters;
  values_[OwnName(run)] = median;
  for (const auto& [name, counter] : run.counters) {
    values_[OwnName(run) + ":" + name] = counter.value;
    if (name == kLeast) {
      least = counter.value;
    } else {
      counters += fmt::format("{}{}={:.4g}", counters.empty() ? "" : "  ", name, counter.value);
    }
  }
  const std::string median_text = fmt::format("{:.4f}", median);
  const std::string least_text = fmt::format("{:.4f}", least);
  GetOutputStream() << fmt::format("{:<64}{:>12}{:>12}  {}", OwnName(run), median_text, least_text,
                                   counters)
                    << std::endl;
  rows_.rows.push_back({OwnName(run), median_text, least_text, counters});
}

Section SummaryReporter::Targets() const { return TargetSection(values_); }

}  // namespace latticed::bench
