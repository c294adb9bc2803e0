// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a client does with one edit of 17,119 patches at a tolerance of 1e-4 D, one thread: evaluate the patches by itself
// (client/cpp/library/patches), or decode the points that a server has evaluated, from Draco.
//
//   patches/torus-17k/evaluate/<normals>   polynomials, levels, points and triangles; every patch is dirty
//   patches/torus-17k/draco/<normals>      the points alone, with the least bits that the tolerance allows
//   patches/torus-17k/read/<normals>       the patch plan, once. Counter bytes_patch: of its runs
//
// Evaluated points are compared with the definition before they are timed.
#include <memory>
#include <string>
#include <utility>

#include "client/cpp/library/patches/patch_evaluator.h"
#include "client/cpp/library/vertex_decoder.h"
#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/edge_levels.h"
#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/core/patches/patch_scene.h"

namespace latticed::bench {
namespace {

constexpr double kEditTolerance = 1e-4;    // of D
constexpr double kPatchPointError = 1e-5;  // of D: half a unit of 16 bits on each axis

struct PatchNormalsCase {
  const char* name;
  NormalMode mode;
  RestNormals rest;
  v1::NormalMode proto;
};
constexpr PatchNormalsCase kPatchNormals[] = {
    {"none", NormalMode::kNone, RestNormals::kNone, v1::NORMAL_MODE_NONE},
    {"facet", NormalMode::kFacet, RestNormals::kFacet, v1::NORMAL_MODE_FACET},
    {"smooth", NormalMode::kSmooth, RestNormals::kSmooth, v1::NORMAL_MODE_SMOOTH}};

double EditTolerance(const Scenario& scenario) {
  Bounds bounds;
  for (const Vec3d& p : scenario.control_points[0]) bounds.Extend(p);
  return kEditTolerance * bounds.diagonal();
}

// Whether the corners of all patches are where the definition has them.
bool HasExactCorners(const Scenario& scenario, const client::PatchSurface& surface) {
  const DirectFfd direct(*scenario.plan, scenario.control_points[0]);
  const double allowed = kPatchPointError / kEditTolerance * EditTolerance(scenario);
  for (size_t p = 0; p < scenario.plan->patches.size(); ++p) {
    const Vec3d corner =
        ToDouble(surface.positions[surface.first_points[p]]) + scenario.plan->local_origin;
    if (Norm(corner - direct.EvaluatePosition(p, {1, 0, 0}).position) > allowed) return false;
  }
  return true;
}

void EvaluatePatches(benchmark::State& state, const PatchNormalsCase& normals) {
  const Scenario& scenario = SmallScenario(2);
  const auto plan = std::make_shared<PatchPlan>(
      Checked(testing::ReadPlan(testing::WritePlan(scenario.plan, normals.rest))));
  auto evaluator = Checked(client::PatchEvaluator::Create(plan, scenario.plan->structure));
  const std::vector<uint8_t> bounds[2] = {
      testing::EdgeBounds(scenario.plan, scenario.control_points[0]),
      testing::EdgeBounds(scenario.plan, scenario.control_points[1])};
  client::PatchSurface surface;
  CheckOk(
      evaluator.Evaluate(scenario.control_points[0], bounds[0], EditTolerance(scenario), &surface));
  if (!HasExactCorners(scenario, surface))
    return state.SkipWithError("a corner is not where the definition has it");
  size_t frame = 0;
  for (auto _ : state) {
    frame = 1 - frame;
    CheckOk(evaluator.Evaluate(scenario.control_points[frame], bounds[frame],
                               EditTolerance(scenario), &surface));
  }
  state.counters["points"] = static_cast<double>(surface.positions.size());
}

void DecodeEditFromDraco(benchmark::State& state, const PatchNormalsCase& normals) {
  const Scenario& scenario = SmallScenario(2);
  ViewSpec spec{.tolerance = EditTolerance(scenario), .normals = normals.mode};
  spec.position_bits = LeastPositionBits(spec.tolerance, scenario.box).value_or(16);
  const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
  const auto streams = Checked(view->Encode(scenario.all_chunks, Encoding::kDracoPoints));
  v1::ViewOptions options;
  options.set_encoding(v1::ENCODING_DRACO_POINTS);
  options.set_normals(normals.proto);
  v1::Quantisation grid;
  grid.set_step(scenario.box.step(spec.position_bits));
  grid.set_bits(spec.position_bits);
  grid.set_normal_bits(spec.normal_bits);
  client::VertexDecoder decoder;
  client::DecodedPoints points;
  for (auto _ : state) {
    points.positions.clear();
    points.normals.clear();
    std::vector<client::EncodedChunk> chunks;
    for (const uint32_t chunk : scenario.all_chunks) {
      const auto bytes = streams[chunk].span();
      chunks.push_back({.data = {reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                        .point_count = ChunkPoints(*view, *scenario.plan, chunk),
                        .quantisation = &grid});
    }
    CheckOk(decoder.Decode(chunks, options, &points));
  }
  state.counters["points"] = static_cast<double>(points.positions.size());
  state.counters["bits"] = spec.position_bits;
}

void ReadPatchPlan(benchmark::State& state, const PatchNormalsCase& normals) {
  const testing::PlanMessages messages = testing::WritePlan(SmallScenario(2).plan, normals.rest);
  for (auto _ : state) CheckOk(testing::ReadPlan(messages).status());
  size_t bytes = 0;
  for (const PatchRun& run : messages.runs) bytes += run.data.size();
  state.counters["bytes_patch"] =
      static_cast<double>(bytes) / static_cast<double>(messages.header.patch_count);
}

}  // namespace

void RegisterPatchesBenches() {
  for (const PatchNormalsCase& normals : kPatchNormals) {
    const auto named = [&](const char* what) {
      return fmt::format("patches/torus-17k/{}/{}", what, normals.name);
    };
    RegisterTimed(named("evaluate"),
                  [&](benchmark::State& state) { EvaluatePatches(state, normals); });
    RegisterTimed(named("draco"),
                  [&](benchmark::State& state) { DecodeEditFromDraco(state, normals); });
    RegisterTimed(named("read"), [&](benchmark::State& state) { ReadPatchPlan(state, normals); });
  }
}

}  // namespace latticed::bench
