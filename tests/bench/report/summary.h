// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
// One line per benchmark: median and least time of its repetitions, then its counters. At the end
// the targets (targets.h), each beside its measured value. All values of a ratio are from one run,
// because machines are noisy.
// machines are noisy.
#ifndef LATTICED_TESTS_BENCH_REPORT_SUMMARY_H_
#define LATTICED_TESTS_BENCH_REPORT_SUMMARY_H_

#include <map>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "tests/bench/report/report.h"

namespace latticed::bench {

class SummaryReporter : public benchmark::BenchmarkReporter {
 public:
  SummaryReporter();
  bool ReportContext(const Context& context) override;
  void ReportRuns(const std::vector<Run>& reports) override;
  // The table of targets. Rows whose benchmarks did not run are left out.
  Section Targets() const;
  // All rows so far.
  const Section& rows() const { return rows_; }
  bool failed() const { return failed_; }

 private:
  void ReportError(const Run& run);

  std::map<std::string, double>
      values_;  // medians in ms by benchmark, and counters by "benchmark:counter"
  Section rows_;
  bool failed_ = false;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_REPORT_SUMMARY_H_
