// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticed_bench: takes the flags of Google Benchmark (--benchmark_filter=REGEX,
// --benchmark_list_tests). Exits with 1 when a result is not what the definition says.
#include <cstdio>

#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/bench/summary.h"

namespace latticed::bench {

void RegisterTimed(const std::string& name, std::function<void(benchmark::State&)> body) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(body))
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->MinTime(0.1)
      ->Repetitions(5);
}

int Main(int argc, char** argv) {
#ifndef NDEBUG
  std::fputs("latticed_bench: built without NDEBUG; only a Release build is worth timing\n",
             stderr);
  return 2;
#endif
  RegisterFloorBenches();
  RegisterEvaluateBenches();
  RegisterPlanBenches();
  RegisterCodecBenches();
  RegisterDeliveryBenches();
  RegisterEngineBenches();
  RegisterPrecisionBenches();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  SummaryReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.PrintTargets();
  return reporter.failed() ? 1 : 0;
}

}  // namespace latticed::bench

int main(int argc, char** argv) { return latticed::bench::Main(argc, argv); }
