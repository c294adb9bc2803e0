// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Errors against the definition in double, on the models in $LATTICED_SHARED/models (or the torus
// where there are none), also placed 1,000 diagonals away from the origin. Counters: of D, and rad
// per kappa.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/mesh/mesh_io.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

std::shared_ptr<const PolygonMesh> Load(const std::filesystem::path& path, double diagonals_away) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  auto mesh = ReadMesh(MeshFormat::kObj, bytes);
  CheckOk(mesh.status());
  const double shift = diagonals_away * mesh->ComputeBounds().diagonal();
  for (Vec3d& p : mesh->positions) p += Vec3d{shift, -shift, shift};
  return std::make_shared<const PolygonMesh>(*std::move(mesh));
}

void Errors(benchmark::State& state, const Scenario& scenario, Pipeline pipeline) {
  const ViewSpec spec{
      .segments = 4, .normals = NormalMode::kFacet, .format = VertexFormat::kFloat32};
  const auto view = MakeView(scenario, pipeline, spec, 1);
  Precision precision;
  for (auto _ : state) precision = Measure(scenario, pipeline, *view, 1);
  state.counters["position_D"] = precision.position;
  state.counters["normal_kappa"] = precision.normal;
  if (const auto verified = Verify(scenario, pipeline, *view); !verified.ok()) {
    state.SkipWithError(std::string(verified.message()).c_str());
  }
}

void RegisterModel(const std::string& name, const std::filesystem::path& path, double away) {
  for (const int degree : {1, 2, 3}) {
    for (const Pipeline pipeline : {Pipeline::kFused, Pipeline::kGemm}) {
      benchmark::RegisterBenchmark(
          fmt::format("precision/{}/{}/degree{}", name, PipelineName(pipeline), degree).c_str(),
          [=](benchmark::State& state) {
            const auto mesh = path.empty() ? MakeTorus(60, 24) : Load(path, away);
            const int size = 4 + degree;
            Errors(state, MakeScenario(name, mesh, {size, size, size}, {degree, degree, degree}),
                   pipeline);
          })
          ->Iterations(1)
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace

void RegisterPrecisionBenches() {
  RegisterModel("torus", {}, 0);
  const char* shared = std::getenv("LATTICED_SHARED");
  for (const char* name : {"spot", "stanford-bunny", "teapot", "fandisk", "rocker-arm"}) {
    const auto path = std::filesystem::path(shared == nullptr ? "../shared" : shared) / "models" /
                      fmt::format("{}.obj", name);
    if (!std::filesystem::exists(path)) continue;
    RegisterModel(name, path, 0);
    RegisterModel(fmt::format("{}-far-away", name), path, 1000);
  }
}

}  // namespace latticed::bench
