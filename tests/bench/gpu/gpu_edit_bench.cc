// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One control point moves, and only the dirty chunks are evaluated: in an 8 x 8 x 8 lattice, and in
// one of 32 x 32 x 32 around the same mesh. The row's time is by the host's clock, from the call of
// Evaluate until the vertices are in device memory. device_ms is by events. ms:copy is the time
// until the control points are on the device. The points are those that touch the most, the median
// and the least patches; "all" evaluates all chunks by the same call. With 10 segments, and with 4,
// as views have while a lattice is dragged.
#include <algorithm>
#include <cstring>
#include <utility>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu/gpu_scenario.h"

namespace latticed::bench {
namespace {

constexpr int kEditRuns = 100;
constexpr int kEditSegments = 10, kFewSegments = 4;
constexpr size_t kComparedChunks = 64;
constexpr int kLargeSize = 32;  // per axis: 32,768 control points

// A control point by its rank in the number of patches that it touches; kAll marks all chunks dirty.
enum class Pick { kMost, kMedian, kLeast, kAll };

struct Edit {
  uint32_t point = 0;
  uint64_t patches = 0;
  std::vector<uint32_t> chunks;
};

Edit PickEdit(const Scenario& scenario, Pick pick) {
  const auto effects = ControlPointsByEffect(scenario);
  const ControlPointEffect& effect = pick == Pick::kLeast    ? effects.front()
                                     : pick == Pick::kMedian ? effects[effects.size() / 2]
                                                             : effects.back();
  if (pick == Pick::kAll) {
    return {effect.point, scenario.plan->patches.size(), scenario.all_chunks};
  }
  return {effect.point, effect.patches, DirtyChunks(scenario, effect.point)};
}

// After edits, the view must hold the same bits as after a full evaluation.
absl::Status CompareWithFull(const Scenario& scenario, DeformView& view,
                             const std::vector<uint32_t>& chunks) {
  const size_t stride = std::max<size_t>(1, chunks.size() / kComparedChunks);
  const auto read = [&] {
    std::vector<std::vector<uint8_t>> bytes;
    for (size_t i = 0; i < chunks.size(); i += stride) {
      bytes.push_back(ReadChunk(scenario, view, chunks[i]));
    }
    return bytes;
  };
  CheckOk(view.Evaluate(scenario.control_points[0], scenario.box, chunks));
  const auto incremental = read();
  CheckOk(view.Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  if (incremental == read()) return absl::OkStatus();
  return absl::InternalError("dirty chunks differ from a full evaluation");
}

const Scenario& SmallLattice() { return ModelScenario(PaperModels().back(), {2, 2, 2}); }

const Scenario& LargeLattice() {
  static const auto* const scenario =
      new Scenario(MakeScenario(fmt::format("lattice-{}", kLargeSize), SmallLattice().plan->mesh,
                                {kLargeSize, kLargeSize, kLargeSize}, {2, 2, 2}));
  return *scenario;
}

void OnePoint(benchmark::State& state, const Scenario& scenario, Pipeline pipeline,
              const ViewSpec& spec, Pick pick) {
  Gpu& gpu = **TheGpu();
  const auto view = MakeGpuView(gpu.backend(), scenario, pipeline, spec);
  if (!view.ok()) return Skip(state, view.status());
  const Edit edit = PickEdit(scenario, pick);
  std::array<std::vector<Vec3d>, 2> turns{scenario.control_points[0], scenario.control_points[0]};
  turns[1][edit.point] = scenario.control_points[1][edit.point];
  const GpuWork work = [&](int run) {
    return (*view)->Evaluate(turns[static_cast<size_t>(run + 1) % 2], scenario.box, edit.chunks);
  };
  const GpuTimes launch = gpu.LaunchToResult(**view, work, kEditRuns);
  const GpuTimes device = gpu.DeviceTime(**view, work, kEditRuns);
  if (const auto same = CompareWithFull(scenario, **view, edit.chunks); !same.ok()) {
    return Skip(state, same);
  }
  const auto patches = static_cast<double>(edit.patches);
  SetTime(state, launch);
  state.counters["device_ms"] = device.median;
  state.counters["ms:copy"] = StageMs(gpu.Stages(**view, work, kEditRuns), "copy");
  state.counters["control_points"] =
      static_cast<double>(scenario.plan->structure.control_point_count());
  state.counters["dirty_patches"] = patches;
  state.counters["dirty_chunks"] = static_cast<double>(edit.chunks.size());
  state.counters["dirty_share"] = patches / static_cast<double>(scenario.plan->patches.size());
}

}  // namespace

void RegisterGpuEditBenches() {
  for (const auto& [name, pick] : {std::pair{"most", Pick::kMost},
                                   {"median", Pick::kMedian},
                                   {"least", Pick::kLeast},
                                   {"all", Pick::kAll}}) {
    for (const auto& [format_name, format] :
         {std::pair{"float32", VertexFormat::kFloat32}, {"quantised", VertexFormat::kQuantised}}) {
      const ViewSpec spec = GpuSpec(format, NormalMode::kFacet, kEditSegments),
                     few = GpuSpec(format, NormalMode::kFacet, kFewSegments);
      RegisterOnce(fmt::format("gpu/one-control-point/fused/{}/{}", format_name, name),
                   [pick = pick, spec](benchmark::State& state) {
                     OnePoint(state, SmallLattice(), Pipeline::kFused, spec, pick);
                   });
      RegisterOnce(fmt::format("gpu/one-control-point/fused/{}/{}/{}segments", format_name, name,
                               kFewSegments),
                   [pick = pick, few](benchmark::State& state) {
                     OnePoint(state, SmallLattice(), Pipeline::kFused, few, pick);
                   });
      RegisterOnce(fmt::format("gpu/one-control-point-of-32768/fused/{}/{}", format_name, name),
                   [pick = pick, spec](benchmark::State& state) {
                     OnePoint(state, LargeLattice(), Pipeline::kFused, spec, pick);
                   });
    }
  }
  // For comparison: gemm evaluates all patches, however few are dirty.
  RegisterOnce("gpu/one-control-point/gemm/float32/most", [](benchmark::State& state) {
    OnePoint(state, SmallLattice(), Pipeline::kGemm,
             GpuSpec(VertexFormat::kFloat32, NormalMode::kFacet, kEditSegments), Pick::kMost);
  });
}

}  // namespace latticed::bench
