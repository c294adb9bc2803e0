// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the figures that we copied from the paper with each other: its sums and ratios must
// follow from its parts. Then checks the tables with our times beside them.
#include "tests/bench/paper/beside_paper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fmt/format.h"

namespace latticed::bench {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Cells = std::vector<std::string>;

// A printed number is rounded to its last digit: by half of it, and by a hair of ours.
constexpr double kOfThree = 0.5e-3 + 1e-9, kOfTwo = 0.5e-2 + 1e-9;
// Sums of numbers with three digits are exact.
constexpr double kExact = 1e-9;

double SavedPercent(double before, double now) { return 100 * (1 - now / before); }

TEST(PrintedTablesTest, Table1IsTheSumOfItsProducts) {
  for (const PrintedProducts& row : kPaperTable1) {
    for (const auto& form : {row.trivial, row.optimal}) {
      EXPECT_NEAR(form.formula24 + form.formula25, form.sum, kExact);
    }
    EXPECT_NEAR(SavedPercent(row.trivial.sum, row.optimal.sum), row.saved, kOfTwo);
  }
}

TEST(PrintedTablesTest, Table2HasTheRatiosOfItsTimes) {
  for (const PrintedEvaluations& row : kPaperTable2) {
    EXPECT_NEAR(row.shader / row.cuda, row.shader_to_cuda, kOfThree);
    EXPECT_NEAR(row.cpu / row.cuda, row.cpu_to_cuda, kOfTwo);
  }
}

TEST(PrintedTablesTest, Table3IsTheSumOfItsStages) {
  for (size_t i = 0; i < kPaperModelCount; ++i) {
    const PrintedTensorStages& tensor = kPaperTable3Tensor[i];
    const PrintedStages& row = kPaperTable3[i];
    EXPECT_NEAR(tensor.copy + tensor.control_points + tensor.tessellation + tensor.drawing,
                tensor.total, kExact);
    EXPECT_NEAR(SavedPercent(tensor.total, row.total), row.saved, kOfTwo);
    if (!std::isnan(row.formula25)) {
      EXPECT_NEAR(row.formula25 + row.to_vbo, row.formula25_and_to_vbo(), kExact);
    }
  }
  // The two stages that cannot be read.
  EXPECT_NEAR(kPaperTable3[2].formula25_and_to_vbo(), 10.137, kExact);
}

// Each pair is of one program, measured twice.
TEST(PrintedTablesTest, TablesAgreeWithEachOther) {
  for (size_t i = 0; i < kPaperModelCount; ++i) {
    EXPECT_NEAR(kPaperTable2[i].cuda / kPaperTable3[i].total, 1, 0.03);
    if (std::isnan(kPaperTable3[i].formula25)) continue;
    EXPECT_NEAR(kPaperTable1[i].optimal.formula25 / kPaperTable3[i].formula25, 1, 0.01);
  }
}

// "LEAST to MOST" of `values`, each with one digit after the point. Leaves out what is not legible.
std::string Range(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return fmt::format("{:.1f} to {:.1f}", *least, *most);
}

TEST(PrintedTablesTest, SlipsNameTheRangesOfTheTables) {
  std::vector<double> shaders, shaders_more, stages, stages_and_copy;
  for (size_t i = 0; i < kPaperModelCount; ++i) {
    shaders.push_back(kPaperTable2[i].shader_to_cuda);
    shaders_more.push_back(kPaperTable2[i].shader / kPaperTable2[i].cuda - 1);
    const PrintedStages& row = kPaperTable3[i];
    const double tensor = kPaperTable3Tensor[i].control_points + kPaperTable3Tensor[i].tessellation;
    stages.push_back(tensor / (row.samples + row.formula24 + row.formula25));
    stages_and_copy.push_back(tensor / row.computed());
  }
  EXPECT_THAT(kPaperSlipShaders, HasSubstr("Table 2 has " + Range(shaders)));
  EXPECT_THAT(kPaperSlipShaders, HasSubstr("is " + Range(shaders_more) + ","));
  EXPECT_THAT(kPaperSlipTensor, HasSubstr("Table 3 has " + Range(stages)));
  EXPECT_THAT(kPaperSlipTensor, HasSubstr("and " + Range(stages_and_copy) + " with the copy"));
}

// The same for every model.
PaperTimes Measured() {
  PaperTimes times;
  times.gpu = {
      .formula18 = 0.01,
      .formulas2123 = 0.04,
      .trivial = 2,
      .edit = 0.25,
      .copy = 0.003,
      .samples = 0.1,
      .formula24 = 0.005,
      .formula25 = 0.02,
      .rearrange = 0.03,
      .shared = 0.06,
      .optimal = 0.5,
      .formulas617 = 0.07,
      .tensor = TensorRun{.times = {.stages = {{.name = "copy", .device_ms = 0.004},
                                               {.name = "control points", .device_ms = 0.2},
                                               {.name = "rest", .device_ms = 0.05}},
                                    .whole = {.median = 0.75}}},
      .shaders = ShaderTimes{.device = "a device",
                             .control = {.median = 0.5},
                             .vertices = {.captured = {.median = 9}, .drawn = {.median = 8}},
                             .buffer = {.captured = {.median = 7}, .drawn = {.median = 4}}},
      .fused = 0.25,
      .drawing = DrawingTimes{.device = "a device", .times = {.median = 1}}};
  times.cpu = {.trivial = 60, .optimal = 50, .fused = 5, .optimal_alone = 400};
  return times;
}

std::vector<PaperTimes> AllMeasured() { return {kPaperModelCount, Measured()}; }

AllPaperTimes Fixed(const std::vector<PaperTimes>& times) {
  return AllPaperTimes(times.data(), kPaperModelCount);
}

// The cells of all models in the line `name` of a stage.
Cells Line(const Section& section, const std::string& stage, const std::string& name) {
  std::string current;
  for (const Cells& row : section.rows) {
    if (!row[0].empty()) current = row[0];
    if (current == stage && row[1] == name) return {row.begin() + 2, row.end()};
  }
  ADD_FAILURE() << "no line " << name << " of " << stage;
  return {};
}

TEST(BesidePaperTest, EveryCellIsFilledWhereAllIsMeasured) {
  const auto times = AllMeasured();

  for (const Section& section :
       {BesideTable1(Fixed(times)), BesideTable2(Fixed(times)), BesideTable3(Fixed(times))}) {
    for (const Cells& row : section.rows) {
      ASSERT_EQ(row.size(), section.columns.size());
      for (size_t i = 1; i < row.size(); ++i) {
        EXPECT_FALSE(row[i].empty() || row[i] == "-") << section.title << ": " << row[0] << row[1];
      }
    }
  }
}

TEST(BesidePaperTest, Table1HasProductsSumsAndWhatIsSaved) {
  const auto times = AllMeasured();

  const Section table = BesideTable1(Fixed(times));

  EXPECT_THAT(Line(table, "trivial: (21)-(23)", "paper"),
              ElementsAre("3.954", "4.898", "9.861", "20.225", "22.707"));
  EXPECT_THAT(Line(table, "optimal: sum", "ours"), Contains("0.0250").Times(5));
  EXPECT_THAT(Line(table, "optimal: sum", "paper / ours"),
              ElementsAre("113.5", "141.6", "289.3", "597.3", "674.0"));
  EXPECT_THAT(Line(table, "saved, %", "paper"),
              ElementsAre("28.66", "28.08", "26.84", "26.25", "25.87"));
  EXPECT_THAT(Line(table, "saved, %", "ours"), Contains("50.00").Times(5));
  EXPECT_THAT(Line(table, "saved of a whole evaluation, %", "gemm of gemm12"),
              Contains("75.00").Times(5));
  EXPECT_THAT(table.notes.front(), HasSubstr("GeForce GTX 465"));
}

TEST(BesidePaperTest, Table2DrawsWhatThePaperDraws) {
  const auto times = AllMeasured();

  const Section table = BesideTable2(Fixed(times));

  EXPECT_THAT(Line(table, "CUDA, with drawing", "gemm"), Contains("1.5000").Times(5));
  EXPECT_THAT(Line(table, "CUDA, with drawing", "paper / fused"),
              ElementsAre("10.2", "12.4", "25.9", "51.9", "59.6"));
  EXPECT_THAT(Line(table, "tessellation shader, with drawing", "ours"),
              Contains("4.5000").Times(5));
  EXPECT_THAT(Line(table, "shader / CUDA", "gemm"), Contains("3.000").Times(5));
  EXPECT_THAT(Line(table, "CPU", "paper"), ElementsAre("661", "831", "1707", "3528", "4003"));
  EXPECT_THAT(Line(table, "CPU", "paper / gemm, 1 thread"),
              ElementsAre("1.65", "2.08", "4.27", "8.82", "10.0"));
  EXPECT_THAT(Line(table, "CUDA without drawing", "paper"),
              ElementsAre("6.757", "8.468", "16.333", "32.885", "37.458"));
  EXPECT_THAT(Line(table, "CPU / CUDA without drawing", "fused"), Contains("20.00").Times(5));
  EXPECT_THAT(table.notes, Contains(HasSubstr("1.6 to 1.7 times faster")));
}

TEST(BesidePaperTest, Table3SaysWhichFiguresAreNotLegible) {
  const auto times = AllMeasured();

  const Section table = BesideTable3(Fixed(times));

  EXPECT_THAT(Line(table, "(25)", "paper"),
              ElementsAre("2.840", "3.558", "not legible", "15.025", "16.962"));
  EXPECT_THAT(Line(table, "(25)", "paper / gemm"),
              ElementsAre("142.0", "177.9", "not legible", "751.2", "848.1"));
  EXPECT_THAT(Line(table, "(25) and copy to VBO", "paper"),
              ElementsAre("3.950", "4.951", "10.137", "20.935", "23.622"));
  EXPECT_THAT(Line(table, "2013: drawing", "paper"), ElementsAre("6", "7", "16", "32", "37"));
  EXPECT_THAT(Line(table, "2013: total", "ours"), Contains("1.7500").Times(5));
  EXPECT_THAT(Line(table, "total", "paper / fused"),
              ElementsAre("10.1", "12.2", "26.3", "53.4", "61.0"));
  EXPECT_THAT(Line(table, "samples ... copy to VBO", "gemm"), Contains("0.1550").Times(5));
  EXPECT_THAT(Line(table, "total without drawing", "paper"),
              ElementsAre("6.571", "8.237", "16.837", "34.754", "39.243"));
  EXPECT_THAT(Line(table, "total without drawing", "paper / fused"),
              ElementsAre("26.3", "32.9", "67.3", "139.0", "157.0"));
  EXPECT_THAT(Line(table, "saved without drawing, %", "paper"),
              ElementsAre("52.38", "45.98", "53.03", "50.74", "53.41"));
  EXPECT_THAT(Line(table, "saved without drawing, %", "fused"), Contains("66.67").Times(5));
  EXPECT_THAT(Line(table, "saved of 2013's total, %", "gemm"), Contains("14.29").Times(5));
  EXPECT_THAT(Line(table, "2013's stages / samples, (24), (25)", "gemm"),
              Contains("2.000").Times(5));
}

TEST(BesidePaperTest, WithoutAGpuThePapersFiguresAndTheCpusRemain) {
  std::vector<PaperTimes> times(kPaperModelCount);
  for (PaperTimes& t : times) t.cpu = Measured().cpu;

  const Section whole = BesideTable2(Fixed(times)), stages = BesideTable3(Fixed(times));

  EXPECT_THAT(Line(whole, "CPU", "paper / fused"),
              ElementsAre("132.2", "166.2", "341.4", "705.6", "800.6"));
  EXPECT_THAT(Line(whole, "CUDA, with drawing", "paper / gemm"), Contains("-").Times(5));
  EXPECT_THAT(whole.notes, Contains("No drawing: there is no GPU."));
  EXPECT_THAT(Line(stages, "samples", "paper"),
              ElementsAre("2.601", "3.266", "6.680", "13.799", "15.601"));
  EXPECT_THAT(Line(stages, "samples", "gemm"), Contains("-").Times(5));
}

}  // namespace
}  // namespace latticed::bench
