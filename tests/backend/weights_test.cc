// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes with vertex weights: every backend and pipeline against the definition in double, without cracks, and with the same
// bits after edits as in a full evaluation.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

#include "core/ffd/plan/dirty_set.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kWeightsSeed = 20261129;
constexpr double kWeightedNoise = 0.08;

ViewSpec WeightedFloats(int segments, NormalMode normals) {
  return {.segments = segments, .normals = normals, .format = VertexFormat::kFloat32};
}

// A function of the position: small where the triangles are, so that slivers have gentle gradients too.
VertexWeights SmoothWeights(const PolygonMesh& mesh) {
  const Bounds bounds = mesh.ComputeBounds();
  std::vector<float> weights;
  for (const Vec3d p : mesh.positions) {
    weights.push_back(static_cast<float>((p.x - bounds.min.x) / bounds.extent().x));
  }
  return std::make_shared<const std::vector<float>>(std::move(weights));
}

Plan WeightedPlan(PolygonMesh mesh, const LatticeStructure& structure, VertexWeights weights) {
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure, {},
                       NeverStop, std::move(weights));
  EXPECT_OK(plan);
  return plan.ok() ? *plan : nullptr;
}

// Triangles without area, exactly or but for rounding: `height` times as high as long. Each has a normal of its own.
PolygonMesh ThinTriangles(double height) {
  std::mt19937 random(kWeightsSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> integer(-4, 4);
  PolygonMesh mesh;
  for (uint32_t t = 0; t < 60; ++t) {
    Vec3d a{uniform(random), uniform(random), uniform(random)};
    Vec3d side{uniform(random), uniform(random), uniform(random)};
    if (t % 3 == 0) {
      a = {0.25 * integer(random), 0.25 * integer(random), 0.25 * integer(random)};
      side = {0.25 * integer(random), 0.25, 0.25 * integer(random)};
    }
    const Vec3d up{uniform(random), uniform(random), uniform(random)};
    const Vec3d c = a + (t % 2 == 0 ? 0.5 : 0.3) * side + height * up;
    for (const Vec3d& p : {a, a + side, c}) {
      mesh.corner_vertices.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.corner_normals.push_back(t);
      mesh.positions.push_back(p);
    }
    mesh.normals.push_back(ToFloat(up));
    mesh.face_offsets.push_back(static_cast<uint32_t>(mesh.positions.size()));
  }
  return mesh;
}

class Weighted : public BackendTest {
 protected:
  void Check(PolygonMesh mesh, const LatticeOptions& options, NormalMode normals,
             VertexWeights weights, std::span<const int> segments = kFewAndMany) {
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), options);
    const Plan plan = WeightedPlan(std::move(mesh), structure, std::move(weights));
    ASSERT_NE(plan, nullptr);
    ASSERT_TRUE(plan->is_weighted());
    for (const int s : segments) {
      SCOPED_TRACE(fmt::format("{} segments, normals {}, seed {}", s, static_cast<int>(normals),
                               kWeightsSeed));
      ExpectMatchesDefinition(plan, Jitter(structure, kWeightedNoise, kWeightsSeed),
                              WeightedFloats(s, normals));
    }
  }
  void CheckRandom(const PolygonMesh& mesh, const LatticeOptions& options, NormalMode normals,
                   std::span<const int> segments = kFewAndMany) {
    Check(mesh, options, normals, RandomWeights(mesh, kWeightsSeed), segments);
  }

  // Compares the chunks that a watcher was sent with a full evaluation, after each of some edits.
  void Watch(const PolygonMesh& mesh, const LatticeOptions& options, const ViewSpec& spec) {
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), options);
    const Plan plan = WeightedPlan(mesh, structure, RandomWeights(mesh, kWeightsSeed));
    ASSERT_NE(plan, nullptr);
    QuantisationBox box = BoxFor(*plan, Jitter(structure, 0.5, kWeightsSeed));
    std::vector<Vec3d> points = plan->identity_points;
    const auto incremental = MakeView(plan, spec), full = MakeView(plan, spec);
    ASSERT_NE(incremental, nullptr);
    ASSERT_NE(full, nullptr);
    ASSERT_OK(incremental->Evaluate(points, box, AllChunks(*plan)));
    std::vector<std::vector<uint8_t>> watched = ReadAll(*plan, *incremental);
    std::mt19937 random(kWeightsSeed);
    std::uniform_int_distribution<size_t> any(0, points.size() - 1);
    std::uniform_real_distribution<double> noise(-0.05, 0.05);
    for (int edit = 0; edit < 10; ++edit) {
      SCOPED_TRACE(fmt::format("{} segments: edit {}, seed {}", spec.segments, edit, kWeightsSeed));
      const auto index = static_cast<uint32_t>(any(random));
      points[index] += Vec3d{noise(random), noise(random), noise(random)};
      const std::vector<uint32_t> indices = {index};
      std::vector<uint32_t> chunks = DirtyByControlPoints(*plan, indices).chunks;
      if (edit == 5) {
        box.range *= 1.25;
        chunks = AllChunks(*plan);
      }
      ASSERT_OK(incremental->Evaluate(points, box, chunks));
      for (const uint32_t chunk : chunks) ASSERT_OK(incremental->Read(chunk, watched[chunk]));
      ASSERT_OK(full->Evaluate(points, box, AllChunks(*plan)));
      const auto expected = ReadAll(*plan, *full);
      ASSERT_TRUE(watched == expected) << "incremental differs from full";
      ASSERT_EQ(CountCracks(*plan, points, spec.segments, Decode(*plan, spec, box, expected)), 0u);
    }
  }
};

TEST_P(Weighted, AllDegreeMixesMatchDefinition) {
  for (int u = 1; u <= 3; ++u) {
    for (int v = 1; v <= 3; ++v) {
      for (int w = 1; w <= 3; ++w) {
        SCOPED_TRACE(fmt::format("degree {} {} {}", u, v, w));
        const NormalMode normals = (u + v + w) % 2 ? NormalMode::kFacet : NormalMode::kSmooth;
        CheckRandom(TorusMesh(9, 6), {.degree = {u, v, w}}, normals);
      }
    }
  }
}

TEST_P(Weighted, AllSegmentsAndNormalsMatchDefinition) {
  constexpr std::array kSegments = {1, 2, 4, 5, 6, 10, 16, 32};
  for (NormalMode normals : {NormalMode::kNone, NormalMode::kFacet, NormalMode::kSmooth}) {
    CheckRandom(TorusMesh(5, 4), {.degree = {2, 2, 2}, .extra = {1, 1, 0}}, normals, kSegments);
    CheckRandom(OneTriangle(), {.degree = {3, 3, 3}, .extra = {1, 1, 1}}, normals, kSegments);
  }
}

TEST_P(Weighted, AllKindsOfKnotsMatchDefinition) {
  for (KnotKind kind :
       {KnotKind::kUniform, KnotKind::kNonUniform, KnotKind::kUnclamped, KnotKind::kRepeated}) {
    SCOPED_TRACE(fmt::format("knots {}", static_cast<int>(kind)));
    CheckRandom(TorusMesh(8, 5), {.degree = {3, 2, 1}, .extra = {3, 4, 3}, .knots = kind},
                NormalMode::kFacet);
  }
}

TEST_P(Weighted, ObliqueMirroredAndFarAwayFramesMatchDefinition) {
  CheckRandom(TorusMesh(8, 6), {.degree = {2, 3, 1}, .shear = 0.3, .mirrored = true, .scale = 1.6},
              NormalMode::kSmooth);
  CheckRandom(TorusMesh(8, 6, {1500, -2000, 1200}), {.degree = {3, 3, 3}}, NormalMode::kFacet);
}

TEST_P(Weighted, PartlyOutsideMatchesDefinition) {
  for (double shift : {0.0, 0.4, 5.0}) {
    SCOPED_TRACE(fmt::format("shift {}", shift));
    const LatticeOptions options{.degree = {2, 1, 2}, .scale = 0.6, .shift = {shift, 0, 0}};
    CheckRandom(TorusMesh(9, 6), options, NormalMode::kFacet);
    CheckRandom(TorusMesh(9, 6), options, NormalMode::kSmooth);
  }
}

// Whatever rests on a face of the frame is one on both sides, though its control points have moved.
TEST_P(Weighted, SeamsThatRestStayAttached) {
  const PolygonMesh mesh = TorusMesh(9, 6, {1500, -2000, 1200});  // where float32 rounds much
  const LatticeStructure structure =
      MakeStructure(mesh.ComputeBounds(), {.degree = {2, 1, 2}, .extra = {2, 2, 2}, .scale = 0.7});
  std::vector<float> weights;
  const double middle = mesh.ComputeBounds().center().x;
  for (const Vec3d p : mesh.positions) weights.push_back(p.x < middle ? 0 : 0.5f);
  const Plan plan =
      WeightedPlan(mesh, structure, std::make_shared<const std::vector<float>>(std::move(weights)));
  ASSERT_NE(plan, nullptr);
  const std::vector<Vec3d> points = Jitter(structure, kWeightedNoise, kWeightsSeed);
  const std::vector<bool> attached = AttachedSeams(*plan, points);
  const auto resting = static_cast<size_t>(std::ranges::count(attached, true));
  EXPECT_GT(resting, 10u);
  EXPECT_GT(attached.size() - resting, 10u);
  for (const int segments : kFewAndMany) {
    for (const NormalMode normals : {NormalMode::kNone, NormalMode::kFacet, NormalMode::kSmooth}) {
      const auto evaluated = EvaluateAll(plan, points, WeightedFloats(segments, normals));
      EXPECT_EQ(CountCracks(*plan, points, segments, evaluated), 0u);
      ExpectMatchesDefinition(plan, points, WeightedFloats(segments, normals));
    }
  }
}

TEST_P(Weighted, SliversAndFlatMeshesMatchDefinition) {
  const PolygonMesh soup = TriangleSoup(65, kWeightsSeed);
  Check(soup, {.degree = {2, 2, 2}}, NormalMode::kFacet, SmoothWeights(soup));
  Check(soup, {.degree = {3, 1, 2}}, NormalMode::kSmooth, SmoothWeights(soup));
  CheckRandom(soup, {.degree = {2, 2, 2}}, NormalMode::kFacet);
  CheckRandom(FlatGrid(4, 0.0), {.degree = {2, 2, 2}, .extra = {3, 3, 3}, .scale = 1.0},
              NormalMode::kFacet);
}

// Also without weights. The weight has no gradient, and is that of the corners.
TEST_P(Weighted, CollinearTrianglesMatchDefinition) {
  for (const double height : {0.0, 1e-13, 1e-10, 1e-8}) {
    const PolygonMesh mesh = ThinTriangles(height);
    SCOPED_TRACE(fmt::format("height {}, seed {}", height, kWeightsSeed));
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
    for (const int segments : kFewAndMany) {
      ExpectMatchesDefinition(MakeTestPlan(mesh, structure),
                              Jitter(structure, kWeightedNoise, kWeightsSeed),
                              WeightedFloats(segments, NormalMode::kFacet));
    }
    CheckRandom(mesh, {.degree = {2, 2, 2}}, NormalMode::kNone);
    CheckRandom(mesh, {.degree = {3, 1, 2}, .extra = {3, 3, 3}}, NormalMode::kFacet);
  }
}

// Their surfaces have area where the corners' weights differ, but normals are those of the definition, without a gradient.
TEST_P(Weighted, NormalsOfCollinearTrianglesAreThoseOfTheDefinition) {
  for (const double height : {0.0, 1e-13, 1e-10}) {
    const PolygonMesh mesh = ThinTriangles(height);
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.degree = {2, 2, 2}});
    const Plan plan = WeightedPlan(mesh, structure, RandomWeights(mesh, kWeightsSeed));
    ASSERT_NE(plan, nullptr);
    const std::vector<Vec3d> points = Jitter(structure, kWeightedNoise, kWeightsSeed);
    const DirectFfd direct(*plan, points);
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      SCOPED_TRACE(fmt::format("height {}, normals {}, seed {}", height, static_cast<int>(normals),
                               kWeightsSeed));
      const auto kind =
          normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
      const auto found = EvaluateAll(plan, points, WeightedFloats(1, normals));
      ASSERT_EQ(found.size(), 3 * plan->patches.size());
      size_t compared = 0;
      for (size_t i = 0; i < found.size(); ++i) {
        const size_t patch = i / 3;
        const auto& t = TessellationPattern::Get(1).points[i % 3];
        const auto expected = direct.Evaluate(patch, {1.0 * t[0], 1.0 * t[1], 1.0 * t[2]}, kind);
        const auto [least, most] = std::ranges::minmax(plan->CornerWeights(patch));
        if (plan->PatchWeightGradient(patch) != Vec3d{} || least == most) continue;
        if (!(expected.kappa <= kMostKappa)) continue;
        ++compared;
        ASSERT_LE(Angle(found[i].normal, expected.normal), kFusedNormal * expected.kappa)
            << "patch " << patch;
      }
      EXPECT_GT(compared, 100u);
    }
  }
}

TEST_P(Weighted, NeighboursHaveTheSameBits) {
  for (const int segments : kFewAndMany) {
    const ViewSpec floats = WeightedFloats(segments, NormalMode::kSmooth);
    const ViewSpec integers{.segments = segments, .position_bits = 16};
    for (const ViewSpec& spec : {floats, integers}) {
      Watch(TorusMesh(7, 5), {.degree = {2, 2, 2}, .extra = {2, 2, 2}}, spec);
      Watch(TorusMesh(7, 5), {.degree = {2, 1, 3}, .scale = 0.7}, spec);
      Watch(CubeMesh(4), {.degree = {2, 3, 1}, .extra = {3, 3, 3}, .scale = 1.0}, spec);
      // So many control points that CUDA uploads those of an edit alone.
      Watch(TorusMesh(24, 12), {.degree = {2, 2, 2}, .extra = {14, 14, 14}}, spec);
    }
  }
}

TEST_P(Weighted, WeightZeroRestsAndWeightOneFollows) {
  const PolygonMesh mesh = TorusMesh(7, 5);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.degree = {2, 3, 1}});
  const std::vector<Vec3d> points = Jitter(structure, kWeightedNoise, kWeightsSeed);
  const auto constant = [&](float w) {
    return WeightedPlan(
        mesh, structure,
        std::make_shared<const std::vector<float>>(std::vector<float>(mesh.positions.size(), w)));
  };
  const Plan unweighted = MakeTestPlan(mesh, structure);
  for (const int segments : kFewAndMany) {
    const ViewSpec spec = WeightedFloats(segments, NormalMode::kSmooth);
    const auto at_rest = EvaluateAll(constant(0), unweighted->identity_points, spec);

    const auto zero = EvaluateAll(constant(0), points, spec);
    const auto one = EvaluateAll(constant(1), points, spec);
    const auto plain = EvaluateAll(unweighted, points, spec);

    ASSERT_EQ(zero.size(), plain.size());
    for (size_t i = 0; i < zero.size(); ++i) {
      ASSERT_EQ(zero[i].position, at_rest[i].position) << "point " << i;
      ASSERT_LE(Norm(one[i].position - plain[i].position), 1e-5) << "point " << i;
      ASSERT_LE(Angle(one[i].normal, plain[i].normal), 1e-3) << "point " << i;
    }
  }
}

// Most normals are then left to the definition: what is left of one axis is less than float32 has digits.
TEST_P(Weighted, FlattenedLatticesMatchDefinition) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.degree = {2, 3, 1}});
  for (const float weight : {1.0f, 0.5f}) {
    const Plan plan = WeightedPlan(mesh, structure,
                                   std::make_shared<const std::vector<float>>(
                                       std::vector<float>(mesh.positions.size(), weight)));
    for (int axis = 0; axis < 3; ++axis) {
      for (const double left : {1e-3, 1e-5}) {
        std::vector<Vec3d> points = Jitter(structure, kWeightedNoise, kWeightsSeed);
        for (Vec3d& p : points) p[axis] *= left;
        for (const int segments : kFewAndMany) {
          for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
            SCOPED_TRACE(
                fmt::format("weight {}, axis {}, {} left, {} segments, normals {}, seed {}", weight,
                            axis, left, segments, static_cast<int>(normals), kWeightsSeed));
            ExpectMatchesDefinition(plan, points, WeightedFloats(segments, normals));
          }
        }
      }
    }
  }
}

TEST_P(Weighted, TakesToleranceAndBoundsAsWithoutWeights) {
  const PolygonMesh mesh = TorusMesh(7, 5);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = WeightedPlan(mesh, structure, RandomWeights(mesh, kWeightsSeed));

  const auto target = backend_->Prepare(plan, GetParam().pipeline);

  ASSERT_OK(target);
  EXPECT_EQ((*target)->has_edge_bounds(), GetParam().pipeline == Pipeline::kFused);
  EXPECT_OK((*target)->CreateView({.tolerance = 1e-3}));
}

INSTANTIATE_TEST_SUITE_P(Backends, Weighted, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
