// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/conformance.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "tests/backend/definition.h"
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

std::vector<uint32_t> AllChunks(const DeformPlan& plan) {
  std::vector<uint32_t> chunks(plan.chunk_count());
  std::iota(chunks.begin(), chunks.end(), 0u);
  return chunks;
}

QuantisationBox BoxFor(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  Bounds bounds = plan.outside_bounds;
  for (const Vec3d& p : control_points) bounds.Extend(p);
  return FitQuantisationBox(bounds, 1);
}

Vertices Decode(const DeformPlan& plan, const ViewSpec& spec,
                const std::vector<std::vector<uint8_t>>& chunks) {
  Vertices result;
  const bool normals = spec.normals != NormalMode::kNone;
  for (size_t c = 0; c < chunks.size(); ++c) {
    const uint8_t* data = chunks[c].data();
    const size_t n = ChunkPoints(plan, c, spec.segments);
    const auto integer = [&](size_t base, size_t bytes, size_t i) {
      uint16_t value = 0;
      std::memcpy(&value, data + base + i * bytes, bytes);
      return uint32_t{value};
    };
    for (size_t i = 0; i < n; ++i) {
      if (spec.format == VertexFormat::kFloat32) {
        std::array<Vec3f, 2> v;
        std::memcpy(v.data(), data + i * BytesPerPoint(spec), BytesPerPoint(spec));
        result.positions.push_back(ToDouble(v[0]));
        if (normals) result.normals.push_back(ToDouble(v[1]));
        continue;
      }
      result.integers.push_back({integer(0, 2, i), integer(2 * n, 2, i), integer(4 * n, 2, i)});
      const size_t bytes = spec.normal_bits <= 8 ? 1 : 2;
      if (normals) {
        result.octahedral.push_back({integer(6 * n, bytes, i), integer((6 + bytes) * n, bytes, i)});
      }
    }
  }
  return result;
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

Vertices EvaluateAll(Backend& backend, Pipeline pipeline, const Plan& plan,
                     std::span<const Vec3d> control_points, const ViewSpec& spec) {
  const auto view = MakeView(backend, pipeline, plan, spec);
  if (view == nullptr) return {};
  EXPECT_OK(view->Evaluate(control_points, BoxFor(*plan, control_points), AllChunks(*plan)));
  return Decode(*plan, spec, ReadAll(*plan, *view));
}

double Angle(Vec3d a, Vec3d b) { return std::atan2(Norm(Cross(a, b)), Dot(a, b)); }

void BackendTest::SetUp() {
  backend_ = BackendOrSkip(GetParam().backend);
  if (backend_ == nullptr) return;
  ASSERT_EQ(backend_->name(), UnspannedName(GetParam().backend));
}

void BackendTest::ExpectMatchesDefinition(const Plan& plan, std::span<const Vec3d> control_points,
                                          const ViewSpec& spec, size_t stride) {
  ASSERT_NE(plan, nullptr);
  ASSERT_EQ(spec.format, VertexFormat::kFloat32);
  const Pipeline pipeline = GetParam().pipeline;
  const Vertices got = EvaluateAll(plan, control_points, spec);
  const Definition definition(*plan, control_points, spec.segments, spec.normals, stride);
  const size_t q = definition.points_per_patch();
  ASSERT_EQ(got.positions.size(), plan->patches.size() * q);

  const double most_distance = PositionTolerance(pipeline) * definition.scale();
  for (size_t p = 0; p < plan->patches.size(); p += stride) {
    for (size_t i = 0; i < q; ++i) {
      const DirectFfd::SurfacePoint& want = definition.Point(p, i);
      const Vec3d position = got.positions[p * q + i] + plan->local_origin;
      ASSERT_LE(Norm(position - want.position), most_distance) << "patch " << p << " point " << i;
      if (spec.normals == NormalMode::kNone) continue;
      const Vec3d normal = got.normals[p * q + i];
      ASSERT_NEAR(Norm(normal), 1, kUnitTolerance) << "patch " << p << " point " << i;
      ASSERT_LE(Angle(normal, want.normal), definition.NormalTolerance(pipeline, p, i))
          << "patch " << p << " point " << i << " kappa " << want.kappa;
    }
  }
}

}  // namespace latticed::testing
