// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A table of the paper with our figures beside its own: one column per model, a few lines per stage.
//
//   stage   paper          as printed; "not legible" where its print cannot be read
//           NAME           ours; "-" where it was not measured
//           paper / NAME   the ratio
//
// Values and ratios are NaN where they are not legible or not measured.
// Threads  plain data
#ifndef LATTICED_TESTS_BENCH_PAPER_COMPARISON_TABLE_H_
#define LATTICED_TESTS_BENCH_PAPER_COMPARISON_TABLE_H_

#include <array>
#include <string>
#include <utility>

#include "tests/bench/paper/printed_tables.h"
#include "tests/bench/report/report.h"

namespace latticed::bench {

class ComparisonTable {
 public:
  using Values = std::array<double, kPaperModelCount>;  // in the order of kPaperModels

  explicit ComparisonTable(std::string title);

  // Begins a stage that the paper has. `digits` are those after the point in its print.
  void Paper(std::string stage, const Values& paper, int digits);
  // Begins a stage that only we have.
  void OursAlone(std::string stage) { stage_ = std::move(stage); }
  // Our time of the stage in milliseconds, and the ratio.
  void Compare(const std::string& name, const Values& ours);
  // Our figure of the stage, without a ratio.
  void Ours(const std::string& name, const Values& ours, int digits);
  void Note(std::string note) { section_.notes.push_back(std::move(note)); }

  [[nodiscard]] Section Finish() && { return std::move(section_); }

 private:
  void Add(const std::string& name, const auto& cell);

  Section section_;
  std::string stage_;  // empty once a line names it
  Values paper_{};
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_COMPARISON_TABLE_H_
