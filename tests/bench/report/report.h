// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tables of results, for people: as text on the terminal, as Markdown in a file that says what
// made it.
//
// Errors   WriteMarkdown: kInternal where the file cannot be written
// Threads  plain data and pure functions
#ifndef LATTICED_TESTS_BENCH_REPORT_REPORT_H_
#define LATTICED_TESTS_BENCH_REPORT_REPORT_H_

#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace latticed::bench {

struct Section {
  std::string title;
  std::vector<std::string> notes;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  // as many cells as columns
};

// Columns as wide as their widest cell; the first to the left, the others to the right.
[[nodiscard]] std::string ToText(const Section& section);
[[nodiscard]] std::string ToMarkdown(const Section& section);

// "2026-11-21, commit …", the command, the machine, then the sections.
[[nodiscard]] absl::Status WriteMarkdown(const std::string& path, const std::string& command,
                                         std::span<const Section> sections);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_REPORT_REPORT_H_
