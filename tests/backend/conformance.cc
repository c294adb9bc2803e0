// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/conformance.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>

#include "core/ffd/box/bernstein.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/support/pipeline_name.h"

namespace latticed::testing {

std::vector<Subject> Subjects() {
  std::vector<Subject> subjects;
  for (const std::string& name : KnownBackends()) {
    for (Pipeline pipeline :
         {Pipeline::kFused, Pipeline::kGemm, Pipeline::kGemm12, Pipeline::kControlNet}) {
      subjects.push_back({name, pipeline});
    }
    subjects.push_back({SpannedName(name), Pipeline::kFused});  // other pipelines do not span
  }
  return subjects;
}

std::string SubjectName(const ::testing::TestParamInfo<Subject>& info) {
  std::string name = info.param.backend + "_" + std::string(PipelineName(info.param.pipeline));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

Plan MakeTestPlan(PolygonMesh mesh, const LatticeStructure& structure) {
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure);
  EXPECT_OK(plan);
  return plan.ok() ? *plan : nullptr;
}

VertexWeights RandomWeights(const PolygonMesh& mesh, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 2);
  std::vector<float> weights(mesh.positions.size());
  for (float& w : weights) w = std::clamp(uniform(random), 0.0f, 1.0f);
  return std::make_shared<const std::vector<float>>(std::move(weights));
}

std::vector<uint32_t> AllChunks(const DeformPlan& plan) {
  std::vector<uint32_t> chunks(plan.chunk_count());
  std::iota(chunks.begin(), chunks.end(), 0u);
  return chunks;
}

QuantisationBox BoxFor(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  Bounds bounds = plan.outside_bounds;
  const auto own = static_cast<size_t>(plan.structure.control_point_count());
  for (const Vec3d& p : control_points.first(own)) bounds.Extend(p);
  for (const TurnedLattice& lattice : plan.turned) {
    Bounds moves;
    moves.Extend(Vec3d{});
    const auto count = static_cast<size_t>(lattice.structure.control_point_count());
    for (size_t i = lattice.first_point; i < lattice.first_point + count; ++i) {
      moves.Extend(control_points[i] - plan.identity_points[i]);
    }
    bounds = {bounds.min + moves.min, bounds.max + moves.max};
  }
  if (plan.is_weighted()) bounds.Extend(plan.mesh_bounds);  // weight 0 rests
  return FitQuantisationBox(bounds, 1);
}

std::unique_ptr<Backend> BackendOrSkip(const std::string& name) {
  auto backend = MakeBackendByName(name);
  if (backend.ok()) return *std::move(backend);
  [&] {
    if (IsRequired(name)) {
      FAIL() << "LATTICED_REQUIRE_BACKENDS names " << name << ": " << backend.status();
    }
    GTEST_SKIP() << "no backend " << name << " here: " << backend.status().message();
  }();
  return nullptr;
}

std::unique_ptr<DeformView> MakeView(Backend& backend, Pipeline pipeline, const Plan& plan,
                                     const ViewSpec& spec) {
  auto target = backend.Prepare(plan, pipeline);
  EXPECT_OK(target);
  if (!target.ok()) return nullptr;
  EXPECT_EQ((*target)->pipeline(), pipeline);
  auto view = (*target)->CreateView(spec);
  EXPECT_OK(view);
  return view.ok() ? *std::move(view) : nullptr;
}

std::vector<std::vector<uint8_t>> ReadAll(const DeformPlan& plan, DeformView& view) {
  std::vector<std::vector<uint8_t>> chunks(plan.chunk_count());
  for (size_t c = 0; c < chunks.size(); ++c) {
    chunks[c].resize(ChunkPoints(plan, c, view.spec().segments) * BytesPerPoint(view.spec()));
    EXPECT_OK(view.Read(static_cast<uint32_t>(c), chunks[c]));
  }
  return chunks;
}

std::vector<ViewPoint> EvaluateAll(Backend& backend, Pipeline pipeline, const Plan& plan,
                                   std::span<const Vec3d> control_points, const ViewSpec& spec) {
  const auto view = MakeView(backend, pipeline, plan, spec);
  if (view == nullptr) return {};
  const QuantisationBox box = BoxFor(*plan, control_points);
  EXPECT_OK(view->Evaluate(control_points, box, AllChunks(*plan)));
  return Decode(*plan, spec, box, ReadAll(*plan, *view));
}

std::vector<ViewPoint> Decode(const DeformPlan& plan, const ViewSpec& spec,
                              const QuantisationBox& box,
                              const std::vector<std::vector<uint8_t>>& chunks) {
  std::vector<ViewPoint> points;
  for (const std::vector<uint8_t>& chunk : chunks) {
    std::ranges::copy(DecodePoints(plan, spec, box, chunk), std::back_inserter(points));
  }
  return points;
}

size_t CountCracks(const DeformPlan& plan, std::span<const Vec3d> control_points, int segments,
                   std::span<const ViewPoint> points) {
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  const std::vector<bool> attached = AttachedSeams(plan, control_points);
  // The vertex or edge, the side of a detached seam, and the place along the edge.
  using Place = std::tuple<uint32_t, bool, size_t>;
  std::map<Place, Vec3d> corners, inner;
  size_t cracks = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const Patch& patch = plan.patches[p];
    const bool outside = patch.box == plan.outside_box();
    const auto apart = [&](uint32_t seam) {
      return seam != kNoIndex && !attached[seam] && outside;
    };
    const auto compare = [&](std::map<Place, Vec3d>& known, const Place& place, size_t point) {
      const Vec3d position = points[p * pattern.points.size() + point].position;
      cracks += known.try_emplace(place, position).first->second != position;
    };
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t v = patch.vertex[i], e = patch.edge[i];
      const auto& along = pattern.edge_points[i];
      compare(corners, {v, apart(plan.vertices[v].seam), 0}, along[0]);
      // Both ends belong to the vertices, whose seams may differ from the edge's.
      for (size_t k = 1; k + 1 < along.size(); ++k) {
        const size_t place = patch.edge_reversed[i] ? along.size() - 1 - k : k;
        compare(inner, {e, apart(plan.edges[e].seam), place}, along[k]);
      }
    }
  }
  return cracks;
}

Vec3d PointOfNet(const double* net, int n, const std::array<double, 3>& b) {
  Vec3d sum;
  for (int i = n; i >= 0; --i) {
    for (int j = n - i; j >= 0; --j, net += 3) {
      sum += Bernstein(i, j, n - i - j, b[0], b[1], b[2]) * Vec3d{net[0], net[1], net[2]};
    }
  }
  return sum;
}

void BackendTest::SetUp() {
  backend_ = BackendOrSkip(GetParam().backend);
  if (backend_ == nullptr) return;
  ASSERT_EQ(backend_->name(), UnspannedName(GetParam().backend));
}

void BackendTest::ExpectMatchesDefinition(const Plan& plan, std::span<const Vec3d> control_points,
                                          const ViewSpec& spec, size_t stride) {
  ASSERT_NE(plan, nullptr);
  ASSERT_EQ(spec.format, VertexFormat::kFloat32);
  const auto view = MakeView(plan, spec);
  ASSERT_NE(view, nullptr);
  const QuantisationBox box = BoxFor(*plan, control_points);
  ASSERT_OK(view->Evaluate(control_points, box, AllChunks(*plan)));
  const size_t size = TessellationPattern::Get(spec.segments).points.size() * BytesPerPoint(spec);
  std::vector<uint32_t> patches;
  std::vector<uint8_t> chunk, compared;
  for (uint32_t c = 0; c < plan->chunk_count(); ++c) {
    const auto [first, last] = plan->ChunkPatches(c);
    chunk.resize((last - first) * size);
    ASSERT_EQ(ChunkPoints(*plan, c, spec.segments) * BytesPerPoint(spec), chunk.size());
    ASSERT_OK(view->Read(c, chunk));
    for (size_t p = (first + stride - 1) / stride * stride; p < last; p += stride) {
      patches.push_back(static_cast<uint32_t>(p));
      const auto bytes = std::span(chunk).subspan((p - first) * size, size);
      compared.insert(compared.end(), bytes.begin(), bytes.end());
    }
  }
  ASSERT_EQ(patches.size(), (plan->patches.size() + stride - 1) / stride);
  ASSERT_OK(Definition(*plan, control_points, spec.segments, spec.normals, std::move(patches))
                .Check(GetParam().pipeline, DecodePoints(*plan, spec, box, compared)));
}

}  // namespace latticed::testing
