// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/paper.h"

#include <cmath>
#include <string>
#include <utility>

#include "core/ffd/stage_matrices.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/bench/paper/paper_measure.h"
#include "tests/bench/work.h"

namespace latticed::bench {
namespace {

constexpr char kUnknown[] = "not known";
constexpr int kPaperSegments = 10;

struct Row {
  PaperModel model;
  PaperGpuTimes gpu;
  PaperCpuTimes cpu;
};
using Cells = std::vector<std::string>;

std::string Ms(double value) { return std::isnan(value) ? "-" : fmt::format("{:.4f}", value); }
std::string Ratio(double numerator, double denominator) {
  const double ratio = numerator / denominator;
  return std::isnan(ratio) ? "-" : fmt::format("{:.1f}", ratio);
}
std::string Millions(double count) { return fmt::format("{:.1f}", count * 1e-6); }
std::string Name(const Row& row) { return row.model.name; }
std::string Patches(const Row& row) { return fmt::format("{}", row.model.patches); }

// The paper's Table 3, on its GTX 465, for its smallest and largest model: the sum of samples,
// (24), (25) and rearranging, and the same with drawing. Sources disagree on the sums with drawing,
// so both values are shown.
struct PaperSum {
  const char* computed;
  const char* drawn;
};
PaperSum SumInPaper(const PaperModel& model) {
  if (model.patches == PaperModels().front().patches) return {"6.6", "12.6-12.8"};
  if (model.patches == PaperModels().back().patches) return {"39.2", "74.5-76.2"};
  return {kUnknown, kUnknown};
}

Section Products(const std::vector<Row>& rows) {
  Section section{
      .title = "Products on the GPU, ms: trivial (18), (21)-(23) against optimal (24), (25)",
      .notes = {},
      .columns = {"model", "patches", "(18)", "(21)-(23)", "(24)", "(25)", "trivial / optimal",
                  "whole evaluations", "paper: ratio"},
      .rows = {}};
  for (const Row& row : rows) {
    const PaperGpuTimes& t = row.gpu;
    section.rows.push_back(Cells{Name(row), Patches(row), Ms(t.formula18), Ms(t.formulas2123),
                                 Ms(t.formula24), Ms(t.formula25),
                                 Ratio(t.formula18 + t.formulas2123, t.formula24 + t.formula25),
                                 Ratio(t.trivial, t.optimal + t.formula24), "2.6 to 2.8"});
  }
  section.notes = {
      "(18) and (24) in double, then rounded; the gemm pipeline keeps (24) and does not repeat it.",
      "The paper: the range of its Table 2, where its text says 1.6 to 1.7; single models, and "
      "which columns are compared, are not in our sources."};
  return section;
}

Section Devices(const std::vector<Row>& rows) {
  Section section{.title = "CUDA against CPU, ms a whole evaluation",
                  .notes = {"CPU with all threads, and gemm with one; every form verified.",
                            "The paper's own figures of this comparison are not known here."},
                  .columns = {"model", "patches", "CPU gemm12", "CPU gemm", "1 thread", "CPU fused",
                              "GPU gemm12", "GPU gemm", "GPU fused", "gemm: CPU / GPU",
                              "1 thread / GPU", "fused: CPU / GPU", "paper"},
                  .rows = {}};
  for (const Row& row : rows) {
    const PaperGpuTimes& g = row.gpu;
    const PaperCpuTimes& c = row.cpu;
    section.rows.push_back(
        Cells{Name(row), Patches(row), Ms(c.trivial), Ms(c.optimal), Ms(c.optimal_alone),
              Ms(c.fused), Ms(g.trivial), Ms(g.optimal), Ms(g.fused), Ratio(c.optimal, g.optimal),
              Ratio(c.optimal_alone, g.optimal), Ratio(c.fused, g.fused), kUnknown});
  }
  return section;
}

Section Stages(const std::vector<Row>& rows) {
  Section section{.title = "Stages of the optimal form on the GPU, ms by events",
                  .notes = {},
                  .columns = {"model", "patches", "edit (host)", "copy", "samples", "(24)", "(25)",
                              "rearrange", "samples ... rearrange", "paper", "paper / ours",
                              "paper, drawn", "shared points", "fused, all of it"},
                  .rows = {}};
  for (const Row& row : rows) {
    const PaperGpuTimes& t = row.gpu;
    const double sum = t.samples + t.formula24 + t.formula25 + t.rearrange;
    const PaperSum paper = SumInPaper(row.model);
    const double known =
        paper.computed == std::string(kUnknown) ? kNotMeasured : std::stod(paper.computed);
    section.rows.push_back(Cells{Name(row), Patches(row), Ms(t.edit), Ms(t.copy), Ms(t.samples),
                                 Ms(t.formula24), Ms(t.formula25), Ms(t.rearrange), Ms(sum),
                                 paper.computed, Ratio(known, sum), paper.drawn, Ms(t.shared),
                                 Ms(t.fused)});
  }
  section.notes = {
      "Models: the sample knot, cut to the paper's numbers of patches and named after its models, "
      "which are not available.",
      "Paper: Table 3 on its GTX 465, smallest and largest model; single stages and other models "
      "are not in our sources.",
      "Rearranging includes normals. Shared points make the surface watertight; the paper has no "
      "such stage. The fused form is a whole evaluation with the copy."};
  return section;
}

// Nanoseconds per point.
double PointNs(double ms, double points) { return ms * 1e6 / points; }
std::string Ns(double value) { return std::isnan(value) ? "-" : fmt::format("{:.4f}", value); }

// Our pipelines evaluate all points of a patch's pattern.
double PatternPoints(const Row& row) {
  return static_cast<double>(row.model.patches) * PointsPerPatch(kPaperSegments);
}

// Times of the tensor product.
double TensorMs(const Row& row) {
  return row.gpu.tensor.ok() ? row.gpu.tensor->times.whole.median : kNotMeasured;
}
double TensorPointNs(const Row& row) {
  if (!row.gpu.tensor.ok()) return kNotMeasured;
  return PointNs(TensorMs(row), static_cast<double>(row.gpu.tensor->points));
}

Section Algorithms(const std::vector<Row>& rows) {
  Section section{.title = "Tensor products on the GPU: ms; ratios of whole models, and of a point",
                  .notes = {},
                  .columns = {"model", "patches", "points of patches", "surfaces", "points",
                              "control points", "tessellation", "total", "optimal form: total",
                              "fused: total", "tensor / optimal", "tensor / fused",
                              "tensor / optimal, a point", "tensor / fused, a point", "paper"},
                  .rows = {}};
  for (const Row& row : rows) {
    const PaperGpuTimes& t = row.gpu;
    const double pattern = PatternPoints(row), ms = TensorMs(row), ns = TensorPointNs(row);
    Cells cells{Name(row), Patches(row), fmt::format("{:.0f}", pattern)};
    if (t.tensor.ok()) {
      cells.insert(cells.end(),
                   {fmt::format("{}", t.tensor->surfaces), fmt::format("{}", t.tensor->points),
                    Ms(StageMs(t.tensor->times.stages, "control points")),
                    Ms(StageMs(t.tensor->times.stages, "rest"))});
    } else {
      cells.insert(cells.end(), 4, "-");
    }
    cells.insert(cells.end(), {Ms(ms), Ms(t.optimal), Ms(t.fused), Ratio(ms, t.optimal),
                               Ratio(ms, t.fused), Ratio(ns, PointNs(t.optimal, pattern)),
                               Ratio(ns, PointNs(t.fused, pattern)), kUnknown});
    section.rows.push_back(std::move(cells));
  }
  section.notes = {
      "Tensor product: Cui & Feng 2013, two kernels that we wrote. A surface of degree 6 x 6 "
      "for each polygon that a knot box leaves of a source triangle, from 49 samples over the "
      "smallest rectangle in its plane; a grid of 10 x 10 cells over the rectangle, cells on the "
      "polygon's boundary clipped against it. Rectangles and trimming are made once, as our plans "
      "are. Vertices are verified at their own coordinates, positions to 1e-6 D; not watertight.",
      "A trimmed grid has more points of one triangle than its pattern's 66, and fewer of a larger "
      "polygon than the patterns of its patches: hence ratios of a point beside those of models. "
      "The next table has times of a point, and the third algorithm, tessellation shaders."};
  return section;
}

Cells ShaderCells(const Row& row) {
  const PaperGpuTimes& t = row.gpu;
  const std::string tensor = Ns(TensorPointNs(row));
  const double optimal = PointNs(t.optimal, PatternPoints(row));
  const double fused = PointNs(t.fused, PatternPoints(row));
  if (!t.shaders.ok()) {
    return {Name(row), Patches(row), "-",         "-",       "-", "-", "-",
            "-",       tensor,       Ns(optimal), Ns(fused), "-", "-", kUnknown};
  }
  const ShaderTimes& s = *t.shaders;
  const double total = s.control.median + s.captured();
  const double points =
      static_cast<double>(row.model.patches) * static_cast<double>(s.distinct_points);
  const double shaders = PointNs(total, points);
  return {Name(row),
          Patches(row),
          Ms(s.control.median),
          Ms(s.captured()),
          Ms(total),
          Ms(s.drawn()),
          fmt::format("{}", s.distinct_points),
          Ns(shaders),
          tensor,
          Ns(optimal),
          Ns(fused),
          Ratio(shaders, optimal),
          Ratio(shaders, fused),
          kUnknown};
}

Section Shaders(const std::vector<Row>& rows) {
  Section section{
      .title = "Tessellation shaders on the GPU: ms, then ns a distinct point",
      .notes = {},
      .columns = {"model", "patches", "control points", "tessellation, captured", "total",
                  "tessellation, drawn", "points", "shaders", "tensor product", "optimal form",
                  "fused", "shaders / optimal", "shaders / fused", "paper"},
      .rows = {}};
  for (const Row& row : rows) section.rows.push_back(ShaderCells(row));
  const auto& shaders = rows.back().gpu.shaders;
  section.notes = {
      shaders.ok() ? "OpenGL: " + shaders->device +
                         ". A data-centre GPU has few graphics units beside its multiprocessors: "
                         "the figures are of them, not of the algorithm alone."
                   : "Not measured: " + std::string(shaders.status().message()) + ".",
      "Control points by (6) on CUDA's clock, tessellation on OpenGL's (GL_TIME_ELAPSED); total is "
      "their sum, and handing nets from one to the other costs nothing in it.",
      "OpenGL at level 10 makes 150 triangles with 91 distinct points of a patch, the paper's "
      "pattern 100 with 66: hence times a point. Transform feedback writes all three vertices of a "
      "triangle, 450 a patch, 10.8 kB. Drawn: into 256 x 256 pixels, nothing captured.",
      "The faster of two ways for control points, vertices of a patch and a storage buffer. "
      "Captured vertices are verified at their own coordinates, positions to 1e-6 D."};
  return section;
}

Section Counts(const std::vector<Row>& rows) {
  Section section{.title = "Formula (20), millions of multiply-adds, and the products' times, ms",
                  .notes = {},
                  .columns = {"model", "patches", "(20) Method 1", "(20) Method 2",
                              "scalars, Method 1", "scalars, Method 2", "resident",
                              "Method 1 (6), (17)", "Method 2 (24), (25)", "1 / 2"},
                  .rows = {}};
  const auto stage = StageMatrices::Get(6, 10);
  if (!stage.ok()) return section;
  const auto m = static_cast<double>((*stage)->m), q = static_cast<double>((*stage)->q);
  for (const Row& row : rows) {
    const auto f = static_cast<double>(row.model.patches);
    const TwoStageWork printed = Formula20Work(m, q, f), scalars = ScalarWork(m, q, f);
    const double method2 = row.gpu.formula24 + row.gpu.formula25;
    section.rows.push_back(
        Cells{Name(row), Patches(row), Millions(printed.method1), Millions(printed.method2),
              Millions(scalars.method1), Millions(scalars.method2), Millions(9 * m * q * f),
              Ms(row.gpu.formulas617), Ms(method2), Ratio(row.gpu.formulas617, method2)});
  }
  section.notes = {
      "(20) counts the product of a number and a vector as one: break-even at f = 3q = 198. In "
      "scalars Method 1 takes 3m²f + 9mqf and Method 2 3m²q + 9mqf: break-even at f = q = 66.",
      "resident: Method 2 on every edit after the first, with (24) kept. (6) runs in double here, "
      "in which a float32 result needs it."};
  return section;
}

}  // namespace

std::vector<Section> PaperTables() {
  std::vector<Row> rows;
  for (const PaperModel& model : PaperModels()) {
    fmt::print(stderr, "latticed_bench: {}, {} patches\n", model.name, model.patches);
    const Scenario& scenario = ModelScenario(model, {2, 2, 2});
    rows.push_back({model, MeasureOnGpu(scenario), MeasureOnCpu(scenario)});
  }
  return {Products(rows),   Devices(rows), Stages(rows),
          Algorithms(rows), Shaders(rows), Counts(rows)};
}

}  // namespace latticed::bench
