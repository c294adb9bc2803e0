// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/tolerance/tolerance_table.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "tests/bench/gpu/gpu.h"
#include "tests/bench/gpu/gpu_scenario.h"
#include "tests/bench/model_scenarios.h"
#include "tests/bench/scenario.h"
#include "tests/bench/tolerance/measured_surface.h"

namespace latticed::bench {
namespace {

constexpr size_t kSampledPatches = 4'000;
constexpr int kRuns = 21;

struct Measured {
  MeasuredSurface surface;
  double certified = 0;  // world units; 0: uniform
  double ms = 0;
  uint64_t vertex_bytes = 0;
};

// The median time in milliseconds of a call that evaluates the view, from the call until its vertices are there.
using Timer = std::function<double(DeformView& view, const GpuWork& work)>;

double HostMs(DeformView&, const GpuWork& work) {
  std::vector<double> times;
  for (int run = 0; run < kRuns; ++run) {
    const auto start = std::chrono::steady_clock::now();
    CheckOk(work(run));
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    times.push_back(time.count());
  }
  std::ranges::nth_element(times, times.begin() + kRuns / 2);
  return times[kRuns / 2];
}

struct TimedBackend {
  Backend& backend;
  Timer time;
};

// nullopt where the backend has no such view.
std::optional<Measured> Measure(const TimedBackend& timed, const Scenario& scenario,
                                double tolerance) {
  const ViewSpec spec{.tolerance = tolerance, .format = VertexFormat::kFloat32};
  auto view = Checked(timed.backend.Prepare(scenario.plan, Pipeline::kFused))->CreateView(spec);
  if (absl::IsInvalidArgument(view.status())) return std::nullopt;
  CheckOk(view.status());
  const size_t stride = std::max<size_t>(1, scenario.plan->patches.size() / kSampledPatches);
  Measured measured;
  CheckOk((*view)->Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  measured.surface = MeasureSurface(**view, *scenario.plan, scenario.control_points[0], stride);
  measured.certified = (*view)->certified_error();
  if (tolerance > 0 && measured.surface.largest_error > measured.certified) {
    CheckOk(absl::InternalError(fmt::format("{}: an error of {} exceeds its certificate {}",
                                            scenario.name, measured.surface.largest_error,
                                            measured.certified)));
  }
  measured.ms = timed.time(**view, [&](int run) {
    return (*view)->Evaluate(scenario.control_points[static_cast<size_t>(run) % 2], scenario.box,
                             scenario.all_chunks);
  });
  for (const auto& [purpose, bytes] : (*view)->memory()) {
    if (purpose.ends_with("vertices")) measured.vertex_bytes += bytes;
  }
  return measured;
}

using Cells = std::vector<std::string>;

void AddRows(const TimedBackend& timed, const Scenario& scenario, Section& section) {
  const auto uniform = Measure(timed, scenario, 0);
  const double diagonal = uniform->surface.diagonal, error = uniform->surface.largest_error;
  const auto add = [&](const char* what, const std::optional<Measured>& m) {
    if (!m) return;
    const auto ratio = [](double a, double b) { return fmt::format("{:.2f}", a / b); };
    section.rows.push_back(Cells{
        scenario.name, fmt::format("{}", scenario.plan->patches.size()), what,
        fmt::format("{}", m->surface.points), fmt::format("{}", m->surface.triangles),
        ratio(static_cast<double>(uniform->surface.points), static_cast<double>(m->surface.points)),
        fmt::format("{:.2g}", m->surface.largest_error / diagonal),
        m->certified > 0 ? fmt::format("{:.2g}", m->certified / diagonal) : "-",
        fmt::format("{:.2f}", static_cast<double>(m->vertex_bytes) * 1e-6),
        fmt::format("{:.3f}", m->ms)});
  };
  add("10 segments", uniform);
  // The points' own error is part of both.
  add("equal error", Measure(timed, scenario, error));
  add("1e-4 D", Measure(timed, scenario, 1e-4 * diagonal));
}

Section TableOf(const TimedBackend& timed) {
  Section section{
      .title = fmt::format("A tolerance against 10 segments, {}: {}", timed.backend.name(),
                           timed.backend.description()),
      .notes = {"Errors as fractions of D. Vertices: float32 with facet normals, megabytes."},
      .columns = {"model", "patches", "view", "points", "triangles", "fewer points", "true error",
                  "certified", "vertices MB", "ms"},
      .rows = {}};
  for (const PaperModel& model : PaperModels()) {
    fmt::print(stderr, "latticed_bench: {}, {} patches\n", model.name, model.patches);
    AddRows(timed, ModelScenario(model, {2, 2, 2}), section);
  }
  for (const char* const name : kModelNames) {
    if (HasModel(name)) AddRows(timed, ModelScenario(name), section);
  }
  return section;
}

}  // namespace

std::vector<Section> ToleranceTables() {
  const auto cpu = MakeCpuBackend({});
  std::vector<Section> sections{TableOf({*cpu, HostMs})};
  const auto gpu = TheGpu();
  if (!gpu.ok()) return sections;
  const Timer time = [&](DeformView& view, const GpuWork& work) {
    return (*gpu)->LaunchToResult(view, work, kRuns).median;
  };
  sections.push_back(TableOf({(*gpu)->backend(), time}));
  return sections;
}

}  // namespace latticed::bench
