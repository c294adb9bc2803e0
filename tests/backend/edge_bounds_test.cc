// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of edge bounds: never below the definition in double, the same bytes after any edits as after a full evaluation,
// and no memory for vertices.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/adaptive/adaptive_reference.h"
#include "core/base/error.h"
#include "core/ffd/plan/dirty_set.h"
#include "core/patches/edge_bound.h"
#include "core/patches/edge_order.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/backend/tolerance/tolerance_scenes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kBoundSeed = kToleranceSeed;
constexpr ViewSpec kBounds{.format = VertexFormat::kEdgeBounds};

// The bytes of all edges, by number.
std::vector<uint8_t> ReadBytes(const DeformPlan& plan, DeformView& view) {
  const std::vector<uint32_t> first = FirstEdges(plan);
  std::vector<uint8_t> bytes(plan.edges.size());
  for (uint32_t c = 0; c < plan.chunk_count(); ++c) {
    EXPECT_OK(view.Read(c, std::span(bytes).subspan(first[c], first[c + 1] - first[c])));
  }
  return bytes;
}

// By edge: the largest bound of its patches in double.
std::vector<double> LargestBounds(const Plan& plan, std::span<const Vec3d> control_points) {
  const auto bounds = AdaptiveReference(plan).Bounds(control_points);
  std::vector<double> largest(plan->edges.size());
  for (size_t p = 0; p < bounds.size(); ++p) {
    for (size_t e = 0; e < 3; ++e) {
      double& edge = largest[plan->patches[p].edge[e]];
      edge = std::max(edge, bounds[p].edge[e]);
    }
  }
  return largest;
}

PolygonMesh Scaled(PolygonMesh mesh, double scale) {
  for (Vec3d& p : mesh.positions) p = scale * p;
  return mesh;
}

class EdgeBounds : public BackendTest {
 protected:
  // The bytes of all edges hold, and the mean of their excess over the bounds in double is small.
  void ExpectBytesHold(const Plan& plan, std::span<const Vec3d> points) {
    const auto view = MakeView(plan, kBounds);
    ASSERT_NE(view, nullptr);
    ASSERT_OK(view->Evaluate(points, BoxFor(*plan, points), AllChunks(*plan)));
    const std::vector<uint8_t> bytes = ReadBytes(*plan, *view);
    const std::vector<double> exact = LargestBounds(plan, points);
    const double unit = CurvatureUnit(plan->mesh_bounds);
    double sum = 0, bent = 0;
    for (size_t e = 0; e < bytes.size(); ++e) {
      ASSERT_LT(bytes[e], 255);
      const double bound = EdgeBound(bytes[e], unit);
      ASSERT_GE(bound, exact[e]) << "edge " << e;
      if (exact[e] < 1e-3 * plan->mesh_bounds.diagonal()) continue;
      sum += bound / exact[e];
      bent += 1;
    }
    ASSERT_GT(bent, 0.1 * static_cast<double>(bytes.size()));
    EXPECT_LT(sum / bent, 1.25);  // half octaves alone: 1.2
  }
};

TEST_P(EdgeBounds, AreNeverBelowTheDefinitionAtAnyDegree) {
  for (int mix = 0; mix < 27; ++mix) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    SCOPED_TRACE(
        fmt::format("degree {} {} {}, seed {}", degree[0], degree[1], degree[2], kBoundSeed));
    PolygonMesh mesh = TorusMesh(12, 7);
    const LatticeStructure structure =
        MakeStructure(mesh.ComputeBounds(), {.degree = degree, .extra = {1, 2, 1}, .scale = 0.8});
    const Plan plan = MakeTestPlan(std::move(mesh), structure);
    ExpectBytesHold(plan, Jitter(structure, 0.2, kBoundSeed));
  }
}

// On the CPU: a GPU has none.
TEST_P(EdgeBounds, WithWeightsAreNeverBelowTheDefinition) {
  for (int mix = 0; mix < 27; mix += 5) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    SCOPED_TRACE(
        fmt::format("degree {} {} {}, seed {}", degree[0], degree[1], degree[2], kBoundSeed));
    const auto mesh = std::make_shared<const PolygonMesh>(TorusMesh(12, 7));
    const LatticeStructure structure =
        MakeStructure(mesh->ComputeBounds(), {.degree = degree, .scale = 0.8});
    std::mt19937 random(kBoundSeed);
    std::uniform_real_distribution<float> weight(0, 1);
    auto weights = std::make_shared<std::vector<float>>(mesh->positions.size());
    for (float& w : *weights) w = weight(random);
    const auto plan = MakePlan(mesh, structure, {}, NeverStop, weights);
    ASSERT_OK(plan);
    const auto target = backend_->Prepare(*plan, GetParam().pipeline);
    ASSERT_OK(target);
    if (!(*target)->has_edge_bounds()) GTEST_SKIP();
    ExpectBytesHold(*plan, Jitter(structure, 0.2, kBoundSeed));
  }
}

TEST_P(EdgeBounds, AreNeverBelowTheDefinitionAtAnyScale) {
  for (const double scale : {1e-15, 1e-12, 1e-6, 1e6, 1e14}) {
    SCOPED_TRACE(fmt::format("scale {}, seed {}", scale, kBoundSeed));
    PolygonMesh mesh = Scaled(TorusMesh(12, 7), scale);
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
    const Plan plan = MakeTestPlan(std::move(mesh), structure);
    ExpectBytesHold(plan, Jitter(structure, 0.2, kBoundSeed));
  }
}

TEST_P(EdgeBounds, OfARestingLatticeAreNothing) {
  PolygonMesh mesh = TorusMesh(12, 7);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.scale = 0.8});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  const auto view = MakeView(plan, kBounds);
  ASSERT_NE(view, nullptr);
  ASSERT_OK(view->Evaluate(plan->identity_points, BoxFor(*plan, plan->identity_points),
                           AllChunks(*plan)));
  EXPECT_EQ(std::ranges::max(ReadBytes(*plan, *view)), 0);
}

TEST_P(EdgeBounds, AreUnknownWhereControlPointsAreHuge) {
  PolygonMesh mesh = TorusMesh(7, 5);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  std::vector<Vec3d> points = plan->identity_points;
  for (size_t i = 0; i < points.size(); i += 2) points[i].x = 1e200;
  const auto view = MakeView(plan, kBounds);
  ASSERT_NE(view, nullptr);
  ASSERT_OK(view->Evaluate(points, BoxFor(*plan, points), AllChunks(*plan)));
  EXPECT_EQ(std::ranges::min(ReadBytes(*plan, *view)), 255);
}

TEST_P(EdgeBounds, AfterAnyEditsAreThoseOfAFullEvaluation) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (ToleranceScene& one : ToleranceScenes()) {
    const LatticeStructure structure = MakeStructure(one.mesh.ComputeBounds(), one.options);
    const Plan plan = MakeTestPlan(std::move(one.mesh), structure);
    const auto incremental = MakeView(plan, kBounds);
    ASSERT_NE(incremental, nullptr);
    std::vector<Vec3d> points = IdentityControlPoints(structure);
    ASSERT_OK(incremental->Evaluate(points, BoxFor(*plan, points), AllChunks(*plan)));
    const std::vector<uint32_t> first = FirstEdges(*plan);
    std::vector<uint8_t> watched = ReadBytes(*plan, *incremental);
    std::mt19937 random(kBoundSeed);
    size_t widened = 0;
    for (int edit = 0; edit < 40; ++edit) {
      SCOPED_TRACE(fmt::format("{}: edit {}, seed {}", one.name, edit, kBoundSeed));
      const uint32_t index = static_cast<uint32_t>(random() % points.size());
      points[index] = random() % 4 == 0
                          ? plan->identity_points[index]
                          : points[index] + Vec3d{noise(random), noise(random), noise(random)};
      const std::vector<uint32_t> named = DirtyByControlPoints(*plan, {{index}}).chunks;
      // Another box each time: bounds do not depend on it.
      ASSERT_OK(incremental->Evaluate(points, BoxFor(*plan, points), named));
      std::vector<uint32_t> changed = named;
      for (const uint32_t chunk : incremental->also_changed()) {
        EXPECT_FALSE(std::ranges::binary_search(named, chunk));
        changed.push_back(chunk);
        ++widened;
      }
      for (const uint32_t c : changed) {
        ASSERT_OK(
            incremental->Read(c, std::span(watched).subspan(first[c], first[c + 1] - first[c])));
      }
      const auto full = MakeView(plan, kBounds);
      ASSERT_OK(full->Evaluate(points, BoxFor(*plan, points), AllChunks(*plan)));
      ASSERT_EQ(watched, ReadBytes(*plan, *full));
    }
    // A bound reaches clean neighbours where a mesh is connected.
    if (one.name == "many boxes") {
      EXPECT_GT(widened, 0u);
    }
  }
}

TEST_P(EdgeBounds, AreEncodedAsTheyAreAndOnlyWhereTheyChanged) {
  PolygonMesh mesh = TorusMesh(14, 9);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  const std::vector<Vec3d> points = Jitter(structure, 0.2, kBoundSeed);
  const std::vector<uint32_t> all = AllChunks(*plan);
  const auto view = MakeView(plan, kBounds);
  ASSERT_NE(view, nullptr);
  ASSERT_OK(view->Evaluate(points, BoxFor(*plan, points), all));
  std::vector<VertexDigest> digests(all.size());
  ASSERT_OK_AND_ASSIGN(const auto encoded, view->Encode(all, Encoding::kPatches, digests));
  std::vector<uint8_t> joined;
  for (const SharedBytes& chunk : encoded) {
    joined.insert(joined.end(), chunk.span().begin(), chunk.span().end());
  }
  EXPECT_EQ(joined, ReadBytes(*plan, *view));

  ASSERT_OK_AND_ASSIGN(const auto again, view->Encode(all, Encoding::kPatches, digests));
  for (const SharedBytes& chunk : again) EXPECT_EQ(chunk.data, nullptr);
  EXPECT_THAT(view->Encode(all, Encoding::kRaw), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_P(EdgeBounds, TakeNoMemoryForVertices) {
  PolygonMesh mesh = TorusMesh(60, 40);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  ASSERT_OK_AND_ASSIGN(const auto target, backend_->Prepare(plan, GetParam().pipeline));
  EXPECT_TRUE(target->has_edge_bounds());
  ASSERT_OK_AND_ASSIGN(const auto view, target->CreateView(kBounds));
  ASSERT_OK(view->Evaluate(plan->identity_points, BoxFor(*plan, plan->identity_points),
                           AllChunks(*plan)));
  const MemoryUse use = view->memory();
  EXPECT_EQ(use.count("vertices"), 0u);
  EXPECT_EQ(use.count("device_vertices"), 0u);
  // Two devices have the edges of their cut twice, and the host has a byte for each edge: 42 bytes a patch.
  EXPECT_LT(HostBytes(use) + DeviceBytes(use), 44 * plan->patches.size());
  const ViewTraits traits = target->Traits(kBounds);
  EXPECT_LE(HostBytes(use), traits.host_bytes);
  EXPECT_EQ(traits.encoder_bytes, 0u);
}

TEST_P(EdgeBounds, OtherPipelinesRefuseThem) {
  PolygonMesh mesh = TorusMesh(5, 4);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  for (const Pipeline pipeline : {Pipeline::kGemm, Pipeline::kGemm12, Pipeline::kControlNet}) {
    SCOPED_TRACE(PipelineName(pipeline));
    ASSERT_OK_AND_ASSIGN(const auto target, backend_->Prepare(plan, pipeline));

    EXPECT_FALSE(target->has_edge_bounds());
    const auto view = target->CreateView(kBounds);
    ASSERT_THAT(view, StatusIs(absl::StatusCode::kInvalidArgument));
    EXPECT_EQ(error::DetailsOf(view.status()).reason, "UNSUPPORTED");
    EXPECT_EQ(error::DetailsOf(view.status()).field, "view.encoding");
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, EdgeBounds,
                         ::testing::Values(Subject{"cpu", Pipeline::kFused},
                                           Subject{"cuda", Pipeline::kFused},
                                           Subject{"cpu-spanned", Pipeline::kFused},
                                           Subject{"cuda-spanned", Pipeline::kFused}),
                         SubjectName);

class SpannedEdgeBounds : public ::testing::TestWithParam<std::string> {};

// The cuts lie anywhere: the bytes of an edge on a cut come from two devices or more.
TEST_P(SpannedEdgeBounds, AreThoseOfOneDeviceAfterAnyEdits) {
  const auto one = BackendOrSkip(GetParam());
  if (one == nullptr) return;
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (const int devices : {2, 4}) {
    ASSERT_OK_AND_ASSIGN(const auto several, MakeSpannedBackend(GetParam(), devices));
    for (ToleranceScene& scene : ToleranceScenes()) {
      const LatticeStructure structure = MakeStructure(scene.mesh.ComputeBounds(), scene.options);
      const Plan plan = MakeTestPlan(std::move(scene.mesh), structure);
      const auto expected = MakeView(*one, Pipeline::kFused, plan, kBounds);
      const auto got = MakeView(*several, Pipeline::kFused, plan, kBounds);
      ASSERT_NE(got, nullptr);
      std::vector<Vec3d> points = IdentityControlPoints(structure);
      std::vector<uint32_t> named = AllChunks(*plan);
      std::vector<VertexDigest> digests(named.size());
      std::mt19937 random(kBoundSeed);
      for (int edit = 0; edit < 30; ++edit) {
        SCOPED_TRACE(
            fmt::format("{}: {} devices, edit {}, seed {}", scene.name, devices, edit, kBoundSeed));
        ASSERT_OK(expected->Evaluate(points, BoxFor(*plan, points), named));
        ASSERT_OK(got->Evaluate(points, BoxFor(*plan, points), named));
        const std::vector<uint8_t> bytes = ReadBytes(*plan, *got);
        ASSERT_EQ(bytes, ReadBytes(*plan, *expected));
        ASSERT_TRUE(std::ranges::equal(got->also_changed(), expected->also_changed()));
        const std::vector<uint32_t> all = AllChunks(*plan);
        auto theirs = digests;
        ASSERT_OK_AND_ASSIGN(const auto sent, got->Encode(all, Encoding::kPatches, digests));
        ASSERT_OK_AND_ASSIGN(const auto same, expected->Encode(all, Encoding::kPatches, theirs));
        for (const uint32_t c : all)
          ASSERT_TRUE(std::ranges::equal(sent[c].span(), same[c].span()));

        const uint32_t index = static_cast<uint32_t>(random() % points.size());
        points[index] += Vec3d{noise(random), noise(random), noise(random)};
        if (edit % 7 == 0) points[index].x = 1e200;  // nothing is known
        named = DirtyByControlPoints(*plan, {{index}}).chunks;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, SpannedEdgeBounds, ::testing::ValuesIn(KnownBackends()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
