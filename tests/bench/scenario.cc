// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/scenario.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include "core/base/bounds.h"
#include "core/cpu/cpu_backend.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/support/test_meshes.h"

namespace latticed::bench {
namespace {

constexpr uint32_t kSeed = 20140601;
constexpr double kJitter = 0.3;  // fraction of a knot box
constexpr double kPadding = 0.05;

std::vector<Vec3d> Jittered(const LatticeStructure& structure, std::mt19937& random) {
  std::uniform_real_distribution<double> jitter(-kJitter, kJitter);
  std::vector<Vec3d> points = IdentityControlPoints(structure);
  Vec3d box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    box[axis] = Norm(structure.frame.edges[a]) / (structure.size[a] - structure.degree[a]);
  }
  for (Vec3d& p : points) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += jitter(random) * box[axis];
  }
  return points;
}

}  // namespace

void CheckOk(const absl::Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "latticed_bench: %s\n", status.ToString().c_str());
  std::exit(1);
}

size_t Scenario::points(int segments) const {
  return plan->patches.size() * static_cast<size_t>(PointsPerPatch(segments));
}

std::shared_ptr<const PolygonMesh> MakeTorus(int around, int across) {
  auto mesh = std::make_shared<PolygonMesh>(testing::TorusMesh(around, across));
  mesh->normals.clear();
  mesh->corner_normals.clear();
  return mesh;
}

VertexWeights WavesOfWeights(const PolygonMesh& mesh) {
  std::vector<float> weights;
  weights.reserve(mesh.positions.size());
  for (const Vec3d p : mesh.positions) {
    weights.push_back(static_cast<float>(0.5 + 0.5 * std::sin(3 * p.x + 2 * p.y)));
  }
  return std::make_shared<const std::vector<float>>(std::move(weights));
}

Scenario MakeScenario(std::string name, std::shared_ptr<const PolygonMesh> mesh,
                      std::array<int, 3> size, std::array<int, 3> degree) {
  const auto lattice = Checked(FitLattice(mesh->ComputeBounds(), size, degree, kPadding));
  return MakeScenario(std::move(name), Checked(MakePlan(std::move(mesh), lattice.structure)));
}

Scenario MakeScenario(std::string name, std::shared_ptr<const DeformPlan> plan) {
  Scenario scenario;
  scenario.name = std::move(name);
  scenario.plan = std::move(plan);
  std::mt19937 random(kSeed);
  Bounds bounds;
  for (auto& points : scenario.control_points) {
    points = Jittered(scenario.plan->structure, random);
    for (const TurnedLattice& lattice : scenario.plan->turned) {
      const std::vector<Vec3d> more = Jittered(lattice.structure, random);
      points.insert(points.end(), more.begin(), more.end());
    }
    for (const Vec3d p : points) bounds.Extend(p);
  }
  scenario.box = FitQuantisationBox(bounds, 1);
  scenario.all_chunks.resize(scenario.plan->chunk_count());
  std::iota(scenario.all_chunks.begin(), scenario.all_chunks.end(), 0u);
  return scenario;
}

Scenario MakeTurnedScenario(std::string name, std::shared_ptr<const PolygonMesh> mesh) {
  constexpr double kTurn = 0.5, kGrowth = 1.5;
  const LatticeStructure own =
      Checked(FitLattice(mesh->ComputeBounds(), {7, 7, 7}, {2, 2, 2}, kPadding)).structure;
  LatticeStructure turned = own;
  LatticeFrame& frame = turned.frame;
  const Vec3d centre = frame.origin + 0.5 * (frame.edges[0] + frame.edges[1] + frame.edges[2]);
  for (Vec3d& edge : frame.edges) {
    const double c = std::cos(kTurn), s = std::sin(kTurn);
    edge = kGrowth * Vec3d{c * edge.x - s * edge.y, s * edge.x + c * edge.y, edge.z};
  }
  frame.origin = centre - 0.5 * (frame.edges[0] + frame.edges[1] + frame.edges[2]);
  const std::array others{turned};
  return MakeScenario(std::move(name),
                      Checked(MakePlan(std::move(mesh), own, {}, NeverStop, nullptr, others)));
}

const Scenario& SmallScenario(int degree) {
  static std::map<int, Scenario>* scenarios = new std::map<int, Scenario>;
  const auto found = scenarios->find(degree);
  if (found != scenarios->end()) return found->second;
  const int size = 5 + degree;
  return scenarios
      ->emplace(degree, MakeScenario("torus-17k", MakeTorus(111, 46), {size, size, size},
                                     {degree, degree, degree}))
      .first->second;
}

const Scenario& LargeScenario() {
  static const Scenario* scenario =
      new Scenario(MakeScenario("torus-114k", MakeTorus(324, 144), {7, 7, 7}, {2, 2, 2}));
  return *scenario;
}

std::unique_ptr<DeformView> MakeView(const Scenario& scenario, Pipeline pipeline,
                                     const ViewSpec& spec, int threads) {
  static std::map<int, std::unique_ptr<Backend>>* backends =
      new std::map<int, std::unique_ptr<Backend>>;
  auto& backend = (*backends)[threads];
  if (backend == nullptr) backend = MakeCpuBackend({.threads = threads, .encoder = nullptr});
  // The view keeps alive what it needs of its target.
  auto view = Checked(Checked(backend->Prepare(scenario.plan, pipeline))->CreateView(spec));
  CheckOk(view->Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  return view;
}

std::vector<uint8_t> ReadChunk(const Scenario& scenario, DeformView& view, uint32_t chunk) {
  const ViewSpec& spec = view.spec();
  std::vector<uint8_t> bytes(ChunkPoints(view, *scenario.plan, chunk) * BytesPerPoint(spec));
  CheckOk(view.Read(chunk, bytes));
  return bytes;
}

}  // namespace latticed::bench
