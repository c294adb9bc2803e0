// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/beside_paper.h"

#include <array>
#include <functional>
#include <string>
#include <utility>

#include "fmt/format.h"
#include "tests/bench/paper/comparison_table.h"

namespace latticed::bench {
namespace {

using Values = ComparisonTable::Values;

// Digits after the point in the paper's print.
constexpr int kMs = 3, kDrawing = 0, kCpuMs = 0, kRatio = 3, kCpuRatio = 2, kPercent = 2;
constexpr int kOurMs = 4;

Values Each(const auto& rows, const auto& value) {
  Values values{};
  for (size_t i = 0; i < values.size(); ++i) values[i] = value(rows[i]);
  return values;
}
// Combines values of the same model.
Values Each(const Values& a, const Values& b, const auto& combine) {
  Values values{};
  for (size_t i = 0; i < values.size(); ++i) values[i] = combine(a[i], b[i]);
  return values;
}
Values Sum(const Values& a, const Values& b) { return Each(a, b, std::plus<>()); }
Values Ratio(const Values& a, const Values& b) { return Each(a, b, std::divides<>()); }
// How many percent of `before` are saved.
Values Saved(const Values& before, const Values& now) {
  return Each(before, now, [](double b, double n) { return 100 * (1 - n / b); });
}

// Of a row of Table 3.
constexpr auto kWithoutDrawing = [](const auto& row) { return row.total - row.drawing; };

// Our times as the rows of the tables need them.
struct Ours {
  explicit Ours(AllPaperTimes all)
      : times(all),
        drawing(Each(all, [](const auto& t) { return t.gpu.drawing_ms(); })),
        gemm(Gpu(&PaperGpuTimes::optimal)),
        fused(Gpu(&PaperGpuTimes::fused)),
        gemm_drawn(Sum(gemm, drawing)),
        fused_drawn(Sum(fused, drawing)),
        tensor(Each(all, [](const auto& t) { return t.gpu.tensor_ms(); })),
        tensor_drawn(Sum(tensor, drawing)) {}

  Values Gpu(double PaperGpuTimes::*time) const {
    return Each(times, [time](const auto& t) { return t.gpu.*time; });
  }
  Values Cpu(double PaperCpuTimes::*time) const {
    return Each(times, [time](const auto& t) { return t.cpu.*time; });
  }
  Values TensorStage(const char* name) const {
    return Each(times, [name](const auto& t) { return t.gpu.tensor_stage_ms(name); });
  }

  AllPaperTimes times;
  Values drawing, gemm, fused, gemm_drawn, fused_drawn, tensor, tensor_drawn;
};

// Says how drawing was measured, or why it was not.
std::string DrawingNote(AllPaperTimes times) {
  const auto& drawing = times.back().gpu.drawing;
  if (!drawing.ok()) return fmt::format("No drawing: {}.", std::string(drawing.status().message()));
  return "Drawing: all triangles of the patterns, once, from a vertex and an index buffer into a "
         "small picture without depth, by the clock of OpenGL: " +
         drawing->device + ".";
}

std::string ShadersNote(AllPaperTimes times) {
  const auto& shaders = times.back().gpu.shaders;
  if (!shaders.ok()) return fmt::format("No shaders: {}.", std::string(shaders.status().message()));
  return fmt::format(
      "Shaders: control points by (6) on CUDA, then OpenGL, which makes {} triangles with {} "
      "points of a patch. The paper's pattern has 100 with 66.",
      shaders->triangles, shaders->distinct_points);
}

void AddForm(ComparisonTable& table, const std::string& form,
             PrintedProducts::Form PrintedProducts::*printed,
             const std::array<const char*, 2>& formulas, const Values& first,
             const Values& second) {
  const auto figure = [&](const std::string& name, double PrintedProducts::Form::*part,
                          const Values& ours) {
    table.Paper(form + ": " + name,
                Each(kPaperTable1, [&](const auto& row) { return row.*printed.*part; }), kMs);
    table.Compare("ours", ours);
  };
  figure(formulas[0], &PrintedProducts::Form::formula24, first);
  figure(formulas[1], &PrintedProducts::Form::formula25, second);
  figure("sum", &PrintedProducts::Form::sum, Sum(first, second));
}

void AddTensorStages(ComparisonTable& table, const Ours& ours) {
  const auto figure = [&](const char* name, double PrintedTensorStages::*stage, int digits,
                          const Values& time) {
    table.Paper(fmt::format("2013: {}", name),
                Each(kPaperTable3Tensor, [&](const auto& row) { return row.*stage; }), digits);
    table.Compare("ours", time);
  };
  using Printed = PrintedTensorStages;
  figure("copy", &Printed::copy, kMs, ours.TensorStage("copy"));
  figure("control points", &Printed::control_points, kMs, ours.TensorStage("control points"));
  figure("tessellation", &Printed::tessellation, kMs, ours.TensorStage("rest"));
  figure("drawing", &Printed::drawing, kDrawing, ours.drawing);
  table.Paper("2013: total without drawing", Each(kPaperTable3Tensor, kWithoutDrawing), kMs);
  table.Compare("ours", ours.tensor);
  figure("total", &Printed::total, kMs, ours.tensor_drawn);
}

void AddStages(ComparisonTable& table, const Ours& ours) {
  const auto figure = [&](const char* name, double PrintedStages::*stage, int digits,
                          const Values& time) {
    table.Paper(name, Each(kPaperTable3, [&](const auto& row) { return row.*stage; }), digits);
    table.Compare("gemm", time);
  };
  using Gpu = PaperGpuTimes;
  figure("copy", &PrintedStages::copy, kMs, ours.Gpu(&Gpu::copy));
  figure("samples", &PrintedStages::samples, kMs, ours.Gpu(&Gpu::samples));
  figure("(24)", &PrintedStages::formula24, kMs, ours.Gpu(&Gpu::formula24));
  figure("(25)", &PrintedStages::formula25, kMs, ours.Gpu(&Gpu::formula25));
  figure("copy to VBO", &PrintedStages::to_vbo, kMs, ours.Gpu(&Gpu::rearrange));
  const Values both = Sum(ours.Gpu(&Gpu::formula25), ours.Gpu(&Gpu::rearrange));
  table.Paper("(25) and copy to VBO",
              Each(kPaperTable3, [](const auto& row) { return row.formula25_and_to_vbo(); }), kMs);
  table.Compare("gemm", both);
  table.OursAlone("edit, on the host");
  table.Ours("gemm", ours.Gpu(&Gpu::edit), kOurMs);
  table.OursAlone("shared points");
  table.Ours("gemm", ours.Gpu(&Gpu::shared), kOurMs);
  figure("drawing", &PrintedStages::drawing, kDrawing, ours.drawing);
  table.Paper("samples ... copy to VBO",
              Each(kPaperTable3, [](const auto& row) { return row.computed(); }), kMs);
  table.Compare("gemm", Sum(Sum(ours.Gpu(&Gpu::samples), ours.Gpu(&Gpu::formula24)), both));
  table.Paper("total without drawing", Each(kPaperTable3, kWithoutDrawing), kMs);
  table.Compare("gemm", ours.gemm);
  table.Compare("fused", ours.fused);
  figure("total", &PrintedStages::total, kMs, ours.gemm_drawn);
  table.Compare("fused", ours.fused_drawn);
}

// What the paper's algorithm saves of the tensor product's time.
void AddSaved(ComparisonTable& table, const Ours& ours) {
  table.Paper("saved of 2013's total, %",
              Each(kPaperTable3, [](const auto& row) { return row.saved; }), kPercent);
  table.Ours("gemm", Saved(ours.tensor_drawn, ours.gemm_drawn), kPercent);
  table.Ours("fused", Saved(ours.tensor_drawn, ours.fused_drawn), kPercent);
  table.Paper("saved without drawing, %",
              Saved(Each(kPaperTable3Tensor, kWithoutDrawing), Each(kPaperTable3, kWithoutDrawing)),
              kPercent);
  table.Ours("gemm", Saved(ours.tensor, ours.gemm), kPercent);
  table.Ours("fused", Saved(ours.tensor, ours.fused), kPercent);
  const Values tensor = Each(kPaperTable3Tensor,
                             [](const auto& row) { return row.control_points + row.tessellation; });
  const Values our_tensor = Sum(ours.TensorStage("control points"), ours.TensorStage("rest"));
  const Values samples =
      Sum(ours.Gpu(&PaperGpuTimes::samples), ours.Gpu(&PaperGpuTimes::formula24));
  table.Paper("2013's stages / samples, (24), (25)",
              Ratio(tensor, Each(kPaperTable3,
                                 [](const auto& row) {
                                   return row.samples + row.formula24 + row.formula25;
                                 })),
              kRatio);
  table.Ours("gemm", Ratio(our_tensor, Sum(samples, ours.Gpu(&PaperGpuTimes::formula25))), kRatio);
}

}  // namespace

Section BesideTable1(AllPaperTimes times) {
  const Ours ours(times);
  using Gpu = PaperGpuTimes;
  const Values formula18 = ours.Gpu(&Gpu::formula18), formulas2123 = ours.Gpu(&Gpu::formulas2123);
  const Values formula24 = ours.Gpu(&Gpu::formula24), formula25 = ours.Gpu(&Gpu::formula25);
  ComparisonTable table("The paper's Table 1: the products alone on the GPU, ms");
  AddForm(table, "trivial", &PrintedProducts::trivial, {"(18)", "(21)-(23)"}, formula18,
          formulas2123);
  AddForm(table, "optimal", &PrintedProducts::optimal, {"(24)", "(25)"}, formula24, formula25);
  table.Paper("saved, %", Each(kPaperTable1, [](const auto& row) { return row.saved; }), kPercent);
  table.Ours("ours", Saved(Sum(formula18, formulas2123), Sum(formula24, formula25)), kPercent);
  table.OursAlone("saved of a whole evaluation, %");
  table.Ours("gemm of gemm12", Saved(ours.Gpu(&Gpu::trivial), ours.gemm), kPercent);
  table.Note(fmt::format("The paper's machine: {}.", kPaperMachine));
  table.Note(
      "Ours: (18) and (24) in double, then rounded. gemm keeps (24) and does not repeat it.");
  return std::move(table).Finish();
}

Section BesideTable2(AllPaperTimes times) {
  const Ours ours(times);
  const Values cpu = ours.Cpu(&PaperCpuTimes::optimal), cpu_fused = ours.Cpu(&PaperCpuTimes::fused);
  const Values shaders = Each(times, [](const auto& t) { return t.gpu.drawn_shaders_ms(); });
  ComparisonTable table("The paper's Table 2: whole evaluations, ms");
  const auto printed = [&](const char* name, double PrintedEvaluations::*figure, int digits) {
    table.Paper(name, Each(kPaperTable2, [&](const auto& row) { return row.*figure; }), digits);
  };
  printed("CUDA, with drawing", &PrintedEvaluations::cuda, kMs);
  table.Compare("gemm", ours.gemm_drawn);
  table.Compare("fused", ours.fused_drawn);
  printed("tessellation shader, with drawing", &PrintedEvaluations::shader, kMs);
  table.Compare("ours", shaders);
  printed("shader / CUDA", &PrintedEvaluations::shader_to_cuda, kRatio);
  table.Ours("gemm", Ratio(shaders, ours.gemm_drawn), kRatio);
  table.Ours("fused", Ratio(shaders, ours.fused_drawn), kRatio);
  printed("CPU", &PrintedEvaluations::cpu, kCpuMs);
  table.Compare("gemm, 1 thread", ours.Cpu(&PaperCpuTimes::optimal_alone));
  table.Compare("gemm", cpu);
  table.Compare("fused", cpu_fused);
  printed("CPU / CUDA with drawing", &PrintedEvaluations::cpu_to_cuda, kCpuRatio);
  table.Ours("gemm", Ratio(cpu, ours.gemm_drawn), kCpuRatio);
  table.Ours("fused", Ratio(cpu_fused, ours.fused_drawn), kCpuRatio);
  const Values cuda =
      Each(Each(kPaperTable2, [](const auto& row) { return row.cuda; }),
           Each(kPaperTable3, [](const auto& row) { return row.drawing; }), std::minus<>());
  table.Paper("CUDA without drawing", cuda, kMs);
  table.Compare("gemm12", ours.Gpu(&PaperGpuTimes::trivial));
  table.Compare("gemm", ours.gemm);
  table.Compare("fused", ours.fused);
  table.Paper("CPU / CUDA without drawing",
              Ratio(Each(kPaperTable2, [](const auto& row) { return row.cpu; }), cuda), kCpuRatio);
  table.Ours("gemm, 1 thread", Ratio(ours.Cpu(&PaperCpuTimes::optimal_alone), ours.gemm),
             kCpuRatio);
  table.Ours("gemm", Ratio(cpu, ours.gemm), kCpuRatio);
  table.Ours("fused", Ratio(cpu_fused, ours.fused), kCpuRatio);
  table.Note(
      "The paper's CPU is CBLAS. Ours has all threads unless a line says one. CUDA without drawing "
      "is the paper's Table 2 less the drawing of its Table 3.");
  table.Note(DrawingNote(times));
  table.Note(ShadersNote(times));
  table.Note(kPaperSlipShaders);
  return std::move(table).Finish();
}

Section BesideTable3(AllPaperTimes times) {
  const Ours ours(times);
  ComparisonTable table("The paper's Table 3: stages on the GPU, ms; 2013 is the tensor product");
  AddTensorStages(table, ours);
  AddStages(table, ours);
  AddSaved(table, ours);
  table.Note(
      "Ours: copy to VBO rearranges the products and makes normals. A total is one whole "
      "evaluation and drawing. It includes shared points, which make the surface watertight and "
      "which the paper does not have. It does not include (24), which gemm keeps. Both algorithms "
      "draw the patterns' triangles; the paper has the same times for both.");
  table.Note("The paper says that an edit of the volume takes less than 1 ms on the host.");
  table.Note(
      "\"not legible\": the paper's print cannot be read there. The sum of both stages follows "
      "from its total.");
  table.Note(kPaperSlipTensor);
  return std::move(table).Finish();
}

}  // namespace latticed::bench
