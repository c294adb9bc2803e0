// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers to reach, each as a ratio of two benchmarks of one run or as one
// value.
#ifndef LATTICED_TESTS_BENCH_REPORT_TARGETS_H_
#define LATTICED_TESTS_BENCH_REPORT_TARGETS_H_

#include <map>
#include <string>

#include "tests/bench/report/report.h"

namespace latticed::bench {

// `values`: medians in ms by benchmark; counters by "benchmark:counter". Targets whose benchmarks
// did not run are left out.
[[nodiscard]] Section TargetSection(const std::map<std::string, double>& values);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_REPORT_TARGETS_H_
