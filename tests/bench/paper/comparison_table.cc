// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/comparison_table.h"

#include <cmath>
#include <vector>

#include "fmt/format.h"

namespace latticed::bench {
namespace {

constexpr char kNotLegibleText[] = "not legible";
constexpr char kNotMeasuredText[] = "-";
constexpr int kOurDigits = 4;  // of milliseconds

std::string Cell(double value, int digits, const char* missing) {
  return std::isnan(value) ? missing : fmt::format("{:.{}f}", value, digits);
}

std::string RatioCell(double paper, double ours) {
  if (std::isnan(paper)) return kNotLegibleText;
  constexpr double kLarge = 10;
  const double ratio = paper / ours;
  return Cell(ratio, ratio < kLarge ? 2 : 1, kNotMeasuredText);
}

}  // namespace

ComparisonTable::ComparisonTable(std::string title)
    : section_{.title = std::move(title), .notes = {}, .columns = {"stage", ""}, .rows = {}} {
  for (const PaperModel& model : kPaperModels) section_.columns.emplace_back(model.name);
}

void ComparisonTable::Add(const std::string& name, const auto& cell) {
  std::vector<std::string> cells{std::exchange(stage_, ""), name};
  for (size_t i = 0; i < kPaperModelCount; ++i) cells.push_back(cell(i));
  section_.rows.push_back(std::move(cells));
}

void ComparisonTable::Paper(std::string stage, const Values& paper, int digits) {
  stage_ = std::move(stage);
  paper_ = paper;
  Add("paper", [&](size_t i) { return Cell(paper[i], digits, kNotLegibleText); });
}

void ComparisonTable::Compare(const std::string& name, const Values& ours) {
  Ours(name, ours, kOurDigits);
  Add("paper / " + name, [&](size_t i) { return RatioCell(paper_[i], ours[i]); });
}

void ComparisonTable::Ours(const std::string& name, const Values& ours, int digits) {
  Add(name, [&](size_t i) { return Cell(ours[i], digits, kNotMeasuredText); });
}

}  // namespace latticed::bench
