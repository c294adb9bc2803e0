// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
// The targets, each for the ratio of two benchmarks of one run or for one value.
// value.
#ifndef LATTICED_TESTS_BENCH_REPORT_TARGETS_H_
#define LATTICED_TESTS_BENCH_REPORT_TARGETS_H_

#include <map>
#include <string>

#include "tests/bench/report/report.h"

namespace latticed::bench {

// `values` holds medians in ms by benchmark, and counters by "benchmark:counter". Targets whose
// benchmarks did not run are left out.
[[nodiscard]] Section TargetSection(const std::map<std::string, double>& values);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_REPORT_TARGETS_H_
