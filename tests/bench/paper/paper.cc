// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/paper.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/ffd/stage_matrices.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/bench/paper/beside_paper.h"
#include "tests/bench/work.h"

namespace latticed::bench {
namespace {

constexpr int kPaperSegments = 10;

using Cells = std::vector<std::string>;

std::string Cell(double value, int digits) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}
std::string Ms(double value) { return Cell(value, 4); }
std::string Ns(double value) { return Cell(value, 4); }
std::string Ratio(double numerator, double denominator) { return Cell(numerator / denominator, 1); }
std::string Millions(double count) { return Cell(count * 1e-6, 1); }

// Nanoseconds per point. Our pipelines evaluate all points of a patch's pattern.
double PatternPointNs(double ms, double patches) {
  return ms * 1e6 / (patches * PointsPerPatch(kPaperSegments));
}
double TensorPointNs(const PaperGpuTimes& t) {
  return t.tensor.ok() ? t.tensor_ms() * 1e6 / static_cast<double>(t.tensor->points) : kNotMeasured;
}
// Vertices captured in memory.
double ShaderPointNs(const PaperGpuTimes& t, double patches) {
  if (!t.shaders.ok()) return kNotMeasured;
  const double ms = t.shaders->control.median + t.shaders->captured();
  return ms * 1e6 / (patches * static_cast<double>(t.shaders->distinct_points));
}

// Three algorithms make other numbers of points from the same patches.
Section Points(AllPaperTimes times) {
  Section section{.title = "One point, ns: shaders, tensor product, gemm and fused on the GPU",
                  .notes = {},
                  .columns = {"model", "surfaces", "points", "control points, ms", "captured, ms",
                              "drawn, ms", "shaders", "tensor", "gemm", "fused", "shaders / gemm",
                              "shaders / fused", "tensor / gemm", "tensor / fused"},
                  .rows = {}};
  for (size_t i = 0; i < kPaperModelCount; ++i) {
    const PaperGpuTimes& t = times[i].gpu;
    const auto patches = static_cast<double>(kPaperModels[i].patches);
    const double shaders = ShaderPointNs(t, patches), tensor = TensorPointNs(t);
    const double gemm = PatternPointNs(t.optimal, patches),
                 fused = PatternPointNs(t.fused, patches);
    Cells cells{kPaperModels[i].name};
    if (t.tensor.ok()) {
      cells.insert(cells.end(),
                   {fmt::format("{}", t.tensor->surfaces), fmt::format("{}", t.tensor->points)});
    } else {
      cells.insert(cells.end(), 2, "-");
    }
    if (t.shaders.ok()) {
      cells.insert(cells.end(), {Ms(t.shaders->control.median), Ms(t.shaders->captured()),
                                 Ms(t.shaders->drawn())});
    } else {
      cells.insert(cells.end(), 3, "-");
    }
    cells.insert(cells.end(), {Ns(shaders), Ns(tensor), Ns(gemm), Ns(fused), Ratio(shaders, gemm),
                               Ratio(shaders, fused), Ratio(tensor, gemm), Ratio(tensor, fused)});
    section.rows.push_back(std::move(cells));
  }
  const auto& shaders = times.back().gpu.shaders;
  section.notes = {
      "Tensor product: Cui & Feng 2013, two kernels that we wrote. A surface of degree 6 x 6 "
      "for each polygon that a knot box leaves of a source triangle, from 49 samples over the "
      "smallest rectangle in its plane; a grid of 10 x 10 cells over the rectangle, cells on the "
      "polygon's boundary clipped against it. Rectangles and trimming are made once, as our plans "
      "are. Vertices are verified at their own coordinates, positions to 1e-6 D; not watertight. "
      "Surfaces and points are those of its trimmed grids.",
      "Shaders: control points by (6) on CUDA's clock, tessellation on OpenGL's (GL_TIME_ELAPSED); "
      "handing nets from one to the other is not counted. OpenGL at level 10 makes 150 triangles "
      "with 91 distinct points of a patch, the paper's pattern 100 with 66: hence times a point, "
      "of captured ones. Transform feedback writes all three vertices of a triangle, 450 a patch, "
      "10.8 kB. Drawn: into 256 x 256 pixels, nothing captured. The faster of two ways for control "
      "points, vertices of a patch and a storage buffer. Captured vertices are verified at their "
      "own coordinates, positions to 1e-6 D.",
      shaders.ok() ? "OpenGL: " + shaders->device +
                         ". A data-centre GPU has few graphics units beside its multiprocessors: "
                         "the figures are of them, not of the algorithm alone."
                   : "No shaders: " + std::string(shaders.status().message()) + "."};
  return section;
}

Section Counts(AllPaperTimes times) {
  Section section{.title = "Formula (20), millions of multiply-adds, and the products' times, ms",
                  .notes = {},
                  .columns = {"model", "patches", "(20) Method 1", "(20) Method 2",
                              "scalars, Method 1", "scalars, Method 2", "resident",
                              "Method 1 (6), (17)", "Method 2 (24), (25)", "1 / 2"},
                  .rows = {}};
  const auto stage = StageMatrices::Get(6, 10);
  if (!stage.ok()) return section;
  const auto m = static_cast<double>((*stage)->m), q = static_cast<double>((*stage)->q);
  for (size_t i = 0; i < kPaperModelCount; ++i) {
    const PaperGpuTimes& t = times[i].gpu;
    const auto f = static_cast<double>(kPaperModels[i].patches);
    const TwoStageWork printed = Formula20Work(m, q, f), scalars = ScalarWork(m, q, f);
    const double method2 = t.formula24 + t.formula25;
    section.rows.push_back(Cells{
        kPaperModels[i].name, fmt::format("{}", kPaperModels[i].patches), Millions(printed.method1),
        Millions(printed.method2), Millions(scalars.method1), Millions(scalars.method2),
        Millions(9 * m * q * f), Ms(t.formulas617), Ms(method2), Ratio(t.formulas617, method2)});
  }
  section.notes = {
      kPaperSlipFormula20,
      "resident: Method 2 on every edit after the first, with (24) kept. (6) runs in double here, "
      "in which a float32 result needs it."};
  return section;
}

}  // namespace

std::vector<Section> PaperTables() {
  std::array<PaperTimes, kPaperModelCount> times;
  for (size_t i = 0; i < times.size(); ++i) {
    const PaperModel& model = kPaperModels[i];
    fmt::print(stderr, "latticed_bench: {}, {} patches\n", model.name, model.patches);
    const Scenario& scenario = ModelScenario(model, {2, 2, 2});
    times[i] = {MeasureOnGpu(scenario), MeasureOnCpu(scenario)};
  }
  std::vector<Section> sections{BesideTable1(times), BesideTable2(times), BesideTable3(times),
                                Points(times), Counts(times)};
  auto& notes = sections.front().notes;
  notes.insert(notes.begin() + 1, fmt::format("This machine: {}.", Machine()));
  notes.push_back(
      "Models: the sample knot, cut to the paper's numbers of patches and named after its models, "
      "which are not available. \"-\": not measured on this machine.");
  return sections;
}

}  // namespace latticed::bench
