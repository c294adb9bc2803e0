// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/conformance.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "core/ffd/tessellation_pattern.h"

namespace latticed::testing {
namespace {

// Row sums of |Bqu inv(B)| at 10 segments, n = 3..9 (exact inverse): what differentiating the
// interpolant does to the rounding of its samples.
constexpr std::array<double, 7> kDerivativeRowSum{29, 69, 148, 303, 608, 1200, 2380};
// Samples, matrix and sums are each rounded to float; 8 half-units in the last place cover them.
constexpr double kProductRounding = 8 * 0x1p-24;

Bounds InfluencingControlPoints(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  Bounds bounds;
  const LatticeStructure& s = plan.structure;
  for (uint32_t b = 0; b < plan.outside_box(); ++b) {
    if (plan.box_patches[b] == plan.box_patches[b + 1]) continue;
    const auto& span = plan.boxes[b].span;
    for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
      for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
        for (int i = span[0] - s.degree[0]; i <= span[0]; ++i) {
          bounds.Extend(control_points[static_cast<size_t>(s.Index(i, j, k))]);
        }
      }
    }
  }
  return bounds;
}

double Angle(Vec3d a, Vec3d b) { return std::atan2(Norm(Cross(a, b)), Dot(a, b)); }

// How far rounding can turn the GEMM normal at a point, in rad: the error of each derivative is the
// row sum times the extent of what was sampled.
double GemmNormalBound(const DeformPlan& plan, const DirectFfd& direct, size_t patch,
                       std::array<double, 3> b, NormalMode mode, double extent) {
  const Patch& p = plan.patches[patch];
  const std::array<Vec3d, 3>& j = direct.EvaluatePosition(patch, b).jacobian;
  const auto carry = [&](Vec3d d) { return d.x * j[0] + d.y * j[1] + d.z * j[2]; };
  const Vec3d corner = plan.vertices[p.vertex[0]].world;
  const Vec3d e1 = plan.vertices[p.vertex[1]].world - corner;
  const Vec3d e2 = plan.vertices[p.vertex[2]].world - corner;
  const Vec3d f = direct.RestFacetNormal(patch);
  const Vec3d pu = carry(e1), pv = carry(e2), pf = carry(f);
  const auto n = static_cast<size_t>(plan.structure.patch_degree());
  const double error = kProductRounding * kDerivativeRowSum[n - 3] * extent;
  if (mode == NormalMode::kFacet) return error * (Norm(pu) + Norm(pv)) / Norm(Cross(pu, pv));
  // Pf is interpolated, not differentiated: its error is that of a position, with its own extent.
  const double error_f = kProductRounding * 32 * (Norm(pf) + CofactorNorm(j));
  const Vec3d normal = direct.RestSmoothNormal(patch, b);
  const double by_f = Dot(normal, f), by_1 = Dot(normal, e1), by_2 = Dot(normal, e2);
  const Vec3d sum = by_f * Cross(pu, pv) + by_1 * Cross(pv, pf) + by_2 * Cross(pf, pu);
  const double turned = std::abs(by_f) * error * (Norm(pu) + Norm(pv)) +
                        std::abs(by_1) * (error * Norm(pf) + error_f * Norm(pv)) +
                        std::abs(by_2) * (error * Norm(pf) + error_f * Norm(pu));
  return turned / Norm(sum);
}

DirectFfd::Normal DirectMode(NormalMode mode) {
  return mode == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
}

}  // namespace

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

void BackendTest::SetUp() {
  const std::string& name = GetParam().backend;
  auto backend = MakeBackendByName(name);
  if (!backend.ok() && IsRequired(name)) {
    FAIL() << "LATTICED_REQUIRE_BACKENDS names " << name << ": " << backend.status();
  }
  if (!backend.ok())
    GTEST_SKIP() << "no backend " << name << " here: " << backend.status().message();
  backend_ = *std::move(backend);
  ASSERT_EQ(backend_->name(), UnspannedName(name));
}

std::unique_ptr<DeformView> BackendTest::MakeView(const Plan& plan, const ViewSpec& spec) {
  auto target = backend_->Prepare(plan, GetParam().pipeline);
  EXPECT_OK(target);
  if (!target.ok()) return nullptr;
  EXPECT_EQ((*target)->pipeline(), GetParam().pipeline);
  auto view = (*target)->CreateView(spec);
  EXPECT_OK(view);
  return view.ok() ? *std::move(view) : nullptr;
}

std::vector<std::vector<uint8_t>> BackendTest::ReadAll(const DeformPlan& plan, DeformView& view) {
  std::vector<std::vector<uint8_t>> chunks(plan.chunk_count());
  for (size_t c = 0; c < chunks.size(); ++c) {
    chunks[c].resize(ChunkPoints(plan, c, view.spec().segments) * BytesPerPoint(view.spec()));
    EXPECT_OK(view.Read(static_cast<uint32_t>(c), chunks[c]));
  }
  return chunks;
}

Vertices BackendTest::EvaluateAll(const Plan& plan, std::span<const Vec3d> control_points,
                                  const ViewSpec& spec) {
  const auto view = MakeView(plan, spec);
  if (view == nullptr) return {};
  EXPECT_OK(view->Evaluate(control_points, BoxFor(*plan, control_points), AllChunks(*plan)));
  return Decode(*plan, spec, ReadAll(*plan, *view));
}

void BackendTest::ExpectMatchesDefinition(const Plan& plan, std::span<const Vec3d> control_points,
                                          const ViewSpec& spec, size_t stride) {
  ASSERT_NE(plan, nullptr);
  ASSERT_EQ(spec.format, VertexFormat::kFloat32);
  const Vertices got = EvaluateAll(plan, control_points, spec);
  const TessellationPattern& pattern = TessellationPattern::Get(spec.segments);
  const size_t q = pattern.points.size();
  ASSERT_EQ(got.positions.size(), plan->patches.size() * q);
  const bool fused = GetParam().pipeline == Pipeline::kFused;
  const DirectFfd direct(*plan, control_points);
  const double over = 1.0 / spec.segments;

  Bounds deformed;
  std::vector<DirectFfd::SurfacePoint> expected(plan->patches.size() * q);
  for (size_t p = 0; p < plan->patches.size(); p += stride) {
    for (size_t i = 0; i < q; ++i) {
      const auto& t = pattern.points[i];
      expected[p * q + i] =
          direct.Evaluate(p, {t[0] * over, t[1] * over, t[2] * over}, DirectMode(spec.normals));
      deformed.Extend(expected[p * q + i].position);
    }
  }
  double d =
      std::max(deformed.diagonal(), InfluencingControlPoints(*plan, control_points).diagonal());
  // A surface collapsed to a point has no size of its own: its distance is what float32 must hold.
  if (d == 0) d = Norm(deformed.center() - plan->local_origin);
  double worst_position = 0, worst_normal = 0;
  for (size_t p = 0; p < plan->patches.size(); p += stride) {
    Bounds patch_bounds;
    for (size_t i = 0; i < q; ++i) patch_bounds.Extend(expected[p * q + i].position);
    for (size_t i = 0; i < q; ++i) {
      const DirectFfd::SurfacePoint& want = expected[p * q + i];
      const Vec3d position = got.positions[p * q + i] + plan->local_origin;
      worst_position = std::max(worst_position, Norm(position - want.position) / d);
      if (spec.normals == NormalMode::kNone) continue;
      const Vec3d normal = got.normals[p * q + i];
      ASSERT_NEAR(Norm(normal), 1, kUnitTolerance) << "patch " << p << " point " << i;
      if (!(want.kappa <= kMostKappa)) continue;
      const auto& t = pattern.points[i];
      // What the samples span: twice the points' bounds, for segments that skip the bulge.
      const double bound =
          fused ? kFusedNormal * want.kappa
                : 2 * 0x1p-24 + GemmNormalBound(*plan, direct, p,
                                                {t[0] * over, t[1] * over, t[2] * over},
                                                spec.normals, 2 * patch_bounds.diagonal());
      const double angle = Angle(normal, want.normal);
      worst_normal = std::max(worst_normal, angle / bound);
      ASSERT_LE(angle, bound) << "patch " << p << " point " << i << " kappa " << want.kappa;
    }
  }
  EXPECT_LE(worst_position, fused ? kFusedPosition : kGemmPosition);
  EXPECT_LE(worst_normal, 1);
}

}  // namespace latticed::testing
