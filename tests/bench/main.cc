// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticed_bench [paper | store [PART] | tolerance] [--large] [--markdown FILE] [flags of Google Benchmark]
//
//   paper            only the tables of Cui & Feng 2014 for this machine (paper.h)
//   store            only the durability of edits, or one part of it (store_table.h)
//   tolerance        only views with a tolerance against uniform segments (tolerance_table.h)
//   --large          also 10^7 patches on the GPU
//   --markdown FILE  also writes the results to FILE, with commit, command and machine
//
// Exits with 1 if a result differs from the definition.
#include <cstdio>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "server/base/process_memory.h"
#include "tests/bench/benches.h"
#include "tests/bench/paper/paper.h"
#include "tests/bench/report/summary.h"
#include "tests/bench/scenario.h"
#include "tests/bench/store/store_table.h"
#include "tests/bench/tolerance/tolerance_table.h"

namespace latticed::bench {
namespace {

struct Options {
  bool paper = false;
  bool store = false;
  std::string store_part;
  bool tolerance = false;
  bool large = false;
  std::string markdown;
  std::string command;
};

// Removes our own arguments. The others are for Google Benchmark.
Options Parse(int& argc, char** argv) {
  constexpr std::string_view kMarkdown = "--markdown";
  Options options;
  for (int i = 0; i < argc; ++i) options.command += fmt::format("{}{}", i > 0 ? " " : "", argv[i]);
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "paper") {
      options.paper = true;
    } else if (argument == "store") {
      options.store = true;
    } else if (options.store && IsStorePart(argument)) {
      options.store_part = argument;
    } else if (argument == "tolerance") {
      options.tolerance = true;
    } else if (argument == "--large") {
      options.large = true;
    } else if (argument == kMarkdown && i + 1 < argc) {
      options.markdown = argv[++i];
    } else {
      argv[kept++] = argv[i];
    }
  }
  argc = kept;
  return options;
}

void Keep(const Options& options, std::span<const Section> sections) {
  if (options.markdown.empty()) return;
  CheckOk(WriteMarkdown(options.markdown, options.command, sections));
}

int Benchmarks(const Options& options) {
  RegisterFloorBenches();
  RegisterEvaluateBenches();
  RegisterPlanBenches();
  RegisterFoldsBenches();
  RegisterWeightsBenches();
  RegisterOutsideBenches();
  RegisterSumBenches();
  RegisterTurnedBenches();
  RegisterMeasureBenches();
  RegisterCodecBenches();
  RegisterDecodeBenches();
  RegisterMeshoptBenches();
  RegisterPatchesBenches();
  RegisterPointsBenches();
  RegisterCpuEncodeBenches();
  RegisterDeliveryBenches();
  RegisterEngineBenches();
  RegisterFairnessBenches();
  RegisterGpuBenches(options.large);
  SummaryReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  std::vector<Section> sections{reporter.rows()};
  if (Section targets = reporter.Targets(); !targets.rows.empty()) {
    fmt::print("{}", ToText(targets));
    sections.push_back(std::move(targets));
  }
  Keep(options, sections);
  return reporter.failed() ? 1 : 0;
}

int Tables(const Options& options, const std::vector<Section>& sections) {
  for (const Section& section : sections) fmt::print("{}", ToText(section));
  Keep(options, sections);
  return 0;
}

}  // namespace

void RegisterTimed(const std::string& name, std::function<void(benchmark::State&)> body) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(body))
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->MinTime(0.1)
      ->Repetitions(5);
}

void CountPoints(benchmark::State& state, size_t points) {
  state.counters["ns_point"] = benchmark::Counter(
      static_cast<double>(points) * 1e-9,
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void RegisterOnce(const std::string& name, std::function<void(benchmark::State&)> body) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(body))
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime()
      ->Iterations(1);
}

void SetTime(benchmark::State& state, GpuTimes times) {
  constexpr double kSecondsPerMs = 1e-3;
  for (auto _ : state) state.SetIterationTime(times.median * kSecondsPerMs);
  state.counters[kLeast] = times.least;
}

void Skip(benchmark::State& state, const absl::Status& status) {
  const bool not_built = absl::IsUnimplemented(status);
  const std::string message(status.message());
  state.SkipWithError((not_built ? fmt::format("{}: {}", kNotBuilt, message) : message).c_str());
}

void SkipNotHere(benchmark::State& state, const absl::Status& why) {
  state.SkipWithError(fmt::format("{}: {}", kNotHere, std::string(why.message())).c_str());
}

int Main(int argc, char** argv) {
  LimitFreeHeapEnds();  // as the server
#ifndef NDEBUG
  std::fputs("latticed_bench: built without NDEBUG; only a Release build is worth timing\n",
             stderr);
  return 2;
#endif
  const Options options = Parse(argc, argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  if (options.paper) return Tables(options, PaperTables());
  if (options.store) return Tables(options, StoreTables(options.store_part));
  if (options.tolerance) return Tables(options, ToleranceTables());
  return Benchmarks(options);
}

}  // namespace latticed::bench

int main(int argc, char** argv) { return latticed::bench::Main(argc, argv); }
