// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tables of results: as text for the terminal, or as Markdown in a file that names how it was made.
//
// Errors   WriteMarkdown: kInternal if the file cannot be written
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
  std::vector<std::vector<std::string>> rows;  // one cell per column
};

// Columns are as wide as their widest cell. The first is aligned left, the others right.
[[nodiscard]] std::string ToText(const Section& section);
[[nodiscard]] std::string ToMarkdown(const Section& section);

// The processor, and the GPU if there is one.
[[nodiscard]] std::string Machine();

// Writes the date, the commit, the machine and the command, then the sections.
[[nodiscard]] absl::Status WriteMarkdown(const std::string& path, const std::string& command,
                                         std::span<const Section> sections);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_REPORT_REPORT_H_
