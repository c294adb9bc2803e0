// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares positions and normals of every backend and pipeline with the definition in double.
#include <gtest/gtest.h>

#include <utility>

#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/real_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kAccuracySeed = 20140310;
constexpr double kNoise = 0.08;  // fraction of the frame: strong bends, few folds

ViewSpec FloatView(int segments, NormalMode normals) {
  return {.segments = segments, .normals = normals, .format = VertexFormat::kFloat32};
}

class Accuracy : public BackendTest {
 protected:
  void CheckFewAndMany(const PolygonMesh& mesh, const LatticeOptions& options, NormalMode normals,
                       double noise = kNoise) {
    for (const int segments : kFewAndMany) {
      SCOPED_TRACE(fmt::format("{} segments", segments));
      Check(mesh, options, FloatView(segments, normals), noise);
    }
  }
  void Check(PolygonMesh mesh, const LatticeOptions& options, const ViewSpec& spec,
             double noise = kNoise) {
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), options);
    ASSERT_OK(Validate(structure));
    const Plan plan = MakeTestPlan(std::move(mesh), structure);
    ASSERT_NE(plan, nullptr);
    ExpectMatchesDefinition(plan, Jitter(structure, noise, kAccuracySeed), spec);
  }
};

TEST_P(Accuracy, AllDegreeMixesMatchDefinition) {
  for (int u = 1; u <= 3; ++u) {
    for (int v = 1; v <= 3; ++v) {
      for (int w = 1; w <= 3; ++w) {
        SCOPED_TRACE(fmt::format("degree {} {} {}, seed {}", u, v, w, kAccuracySeed));
        const NormalMode normals = (u + v + w) % 2 ? NormalMode::kFacet : NormalMode::kSmooth;
        CheckFewAndMany(TorusMesh(9, 6), {.degree = {u, v, w}}, normals);
      }
    }
  }
}

TEST_P(Accuracy, AllKindsOfKnotsMatchDefinition) {
  for (KnotKind kind :
       {KnotKind::kUniform, KnotKind::kNonUniform, KnotKind::kUnclamped, KnotKind::kRepeated}) {
    for (std::array<int, 3> degree : {std::array{1, 1, 1}, {2, 2, 2}, {3, 2, 1}, {3, 3, 3}}) {
      SCOPED_TRACE(fmt::format("knots {}, degree {} {} {}, seed {}", static_cast<int>(kind),
                               degree[0], degree[1], degree[2], kAccuracySeed));
      CheckFewAndMany(TorusMesh(8, 5), {.degree = degree, .extra = {3, 4, 3}, .knots = kind},
                      NormalMode::kFacet);
    }
  }
}

TEST_P(Accuracy, AllSegmentsAndNormalsMatchDefinition) {
  for (int segments : {1, 2, 3, 4, 5, 6, 10, 16, 32}) {
    for (NormalMode normals : {NormalMode::kNone, NormalMode::kFacet, NormalMode::kSmooth}) {
      SCOPED_TRACE(fmt::format("{} segments, normals {}", segments, static_cast<int>(normals)));
      Check(TorusMesh(5, 4), {.degree = {2, 2, 2}, .extra = {1, 1, 0}},
            FloatView(segments, normals));
      Check(OneTriangle(), {.degree = {3, 3, 3}, .extra = {1, 1, 1}}, FloatView(segments, normals));
    }
  }
}

TEST_P(Accuracy, ObliqueAndMirroredFramesMatchDefinition) {
  for (bool mirrored : {false, true}) {
    for (double shear : {0.0, 0.3}) {
      SCOPED_TRACE(fmt::format("mirrored {}, shear {}", mirrored, shear));
      const LatticeOptions options{
          .degree = {2, 3, 1}, .shear = shear, .mirrored = mirrored, .scale = 1.6};
      CheckFewAndMany(TorusMesh(8, 6), options, NormalMode::kSmooth);
      CheckFewAndMany(TorusMesh(8, 6), options, NormalMode::kFacet);
    }
  }
}

TEST_P(Accuracy, OnePatchMatchesDefinition) {
  // There is no interior knot, so the triangle stays whole.
  Check(OneTriangle(), {.degree = {2, 2, 2}, .extra = {0, 0, 0}},
        FloatView(10, NormalMode::kFacet));
}

TEST_P(Accuracy, PatchCountsThatFillNoLanesMatchDefinition) {
  for (int count : {2, 7, 15, 17, 31, 33, 65}) {
    SCOPED_TRACE(fmt::format("{} triangles, seed {}", count, kAccuracySeed));
    CheckFewAndMany(TriangleSoup(count, kAccuracySeed), {.degree = {2, 2, 2}, .extra = {0, 0, 0}},
                    NormalMode::kFacet);
  }
}

TEST_P(Accuracy, SliversMatchDefinition) {
  CheckFewAndMany(TriangleSoup(64, kAccuracySeed), {.degree = {2, 2, 2}}, NormalMode::kFacet);
  CheckFewAndMany(TriangleSoup(64, kAccuracySeed), {.degree = {3, 1, 2}}, NormalMode::kSmooth);
}

TEST_P(Accuracy, PartlyAndWhollyOutsideMatchDefinition) {
  for (double shift : {0.0, 0.4, 5.0}) {
    SCOPED_TRACE(fmt::format("shift {}", shift));
    const LatticeOptions options{.degree = {2, 1, 2}, .scale = 0.6, .shift = {shift, 0, 0}};
    CheckFewAndMany(TorusMesh(9, 6), options, NormalMode::kFacet);
    CheckFewAndMany(TorusMesh(9, 6), options, NormalMode::kSmooth);
  }
}

TEST_P(Accuracy, FlatAndKnotAlignedMeshesMatchDefinition) {
  // At scale 1 the grid's lines lie in knot planes, and the cube's faces in the planes of the frame.
  for (std::array<int, 3> degree : {std::array{1, 1, 1}, {2, 2, 2}, {3, 3, 3}}) {
    const LatticeOptions options{.degree = degree, .extra = {3, 3, 3}, .scale = 1.0};
    CheckFewAndMany(FlatGrid(4, 0.0), options, NormalMode::kFacet);
    CheckFewAndMany(CubeMesh(4), options, NormalMode::kSmooth);
  }
}

TEST_P(Accuracy, FarFromTheOriginMatchesDefinition) {
  // 1,000 diagonals away. The definition itself keeps 12 digits of D there.
  const Vec3d far{1500, -2000, 1200};
  CheckFewAndMany(TorusMesh(8, 6, far), {.degree = {2, 2, 2}}, NormalMode::kFacet);
  CheckFewAndMany(TorusMesh(8, 6, far), {.degree = {3, 3, 3}}, NormalMode::kSmooth);
}

TEST_P(Accuracy, StrongDeformationMatchesDefinition) {
  CheckFewAndMany(TorusMesh(8, 6), {.degree = {3, 2, 3}}, NormalMode::kFacet, 0.5);
  CheckFewAndMany(TorusMesh(8, 6), {.degree = {2, 3, 2}}, NormalMode::kSmooth, 0.5);
}

TEST_P(Accuracy, HundredThousandPatchesMatchDefinition) {
  PolygonMesh mesh = TorusMesh(300, 170);
  const LatticeStructure structure =
      MakeStructure(mesh.ComputeBounds(), {.degree = {2, 2, 2}, .extra = {5, 5, 5}});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  ASSERT_NE(plan, nullptr);
  ASSERT_GE(plan->patches.size(), 100'000u);

  // A prime stride covers every lane and every place in a chunk.
  ExpectMatchesDefinition(plan, Jitter(structure, kNoise, kAccuracySeed),
                          FloatView(2, NormalMode::kFacet), 101);
}

TEST_P(Accuracy, RandomCasesMatchDefinition) {
  constexpr uint32_t kCases = 60;
  for (uint32_t seed = 1; seed <= kCases; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    RandomCase one = DrawCase(seed);
    const NormalMode normals = seed % 2 ? NormalMode::kFacet : NormalMode::kSmooth;
    Check(std::move(one.mesh), one.options, FloatView(one.segments, normals));
    if (HasFailure()) return;
  }
}

TEST_P(Accuracy, RealMeshesMatchDefinition) {
  std::vector<RealMesh> meshes = RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  for (const double diagonals_away : {0.0, 1'000.0}) {
    for (const auto& [name, source] : meshes) {
      SCOPED_TRACE(fmt::format("{}, {} diagonals away", name, diagonals_away));
      PolygonMesh mesh = source;
      const double shift = diagonals_away * mesh.ComputeBounds().diagonal();
      for (Vec3d& p : mesh.positions) p += Vec3d{shift, -shift, shift};
      const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.extra = {3, 3, 3}});
      const Plan plan = MakeTestPlan(std::move(mesh), structure);
      ASSERT_NE(plan, nullptr);
      const std::vector<Vec3d> points = Jitter(structure, kNoise, kAccuracySeed);
      ExpectMatchesDefinition(plan, points, FloatView(10, NormalMode::kFacet), 97);
      for (const int segments : kFewAndMany) {
        ExpectMatchesDefinition(plan, points, FloatView(segments, NormalMode::kSmooth), 89);
      }
    }
  }
}

// The squares of areas exceed the range of float32.
TEST_P(Accuracy, HugeAndTinyLatticesMatchDefinition) {
  constexpr std::array<std::pair<double, double>, 6> kScales{
      {{1e-3, 1e-9}, {1e-3, 1e10}, {1, 1e-9}, {1, 1e10}, {1e14, 1e-9}, {1e14, 3e3}}};
  for (const auto& [of_mesh, of_lattice] : kScales) {
    SCOPED_TRACE(fmt::format("mesh {}, lattice {}, seed {}", of_mesh, of_lattice, kAccuracySeed));
    PolygonMesh mesh = TorusMesh(6, 5);
    for (Vec3d& p : mesh.positions) p = of_mesh * p;
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
    const Plan plan = MakeTestPlan(std::move(mesh), structure);
    std::vector<Vec3d> points = Jitter(structure, kNoise, kAccuracySeed);
    for (Vec3d& p : points) p = of_lattice * p;
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const int segments : kFewAndMany) {
        ExpectMatchesDefinition(plan, points, FloatView(segments, normals));
      }
    }
  }
}

// The normals of a thin patch fit in float32, but intermediate products do not.
TEST_P(Accuracy, HugeLatticesOfThinMeshesMatchDefinition) {
  PolygonMesh mesh = TorusMesh(6, 5);
  for (Vec3d& p : mesh.positions) p = {100 * p.x, 1e-4 * p.y, 1e-4 * p.z};
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  std::vector<Vec3d> points = Jitter(structure, kNoise, kAccuracySeed);
  for (Vec3d& p : points) p = 3e18 * p;
  for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
    for (const int segments : kFewAndMany) {
      SCOPED_TRACE(fmt::format("{} segments, normals {}, seed {}", segments,
                               static_cast<int>(normals), kAccuracySeed));
      ExpectMatchesDefinition(plan, points, FloatView(segments, normals));
    }
  }
}

TEST_P(Accuracy, CollapsedLatticesHaveUnitNormals) {
  PolygonMesh mesh = TorusMesh(6, 5);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  std::vector<Vec3d> plane = IdentityControlPoints(structure);
  for (Vec3d& p : plane) p.z = 0;
  std::vector<Vec3d> line = plane;
  for (Vec3d& p : line) p = {p.x, 0.5 * p.x, 0};
  const std::vector<Vec3d> point(line.size(), Vec3d{0.1, 0.2, 0.3});

  for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
    for (const int segments : kFewAndMany) {
      ExpectMatchesDefinition(plan, plane, FloatView(segments, normals));
      ExpectMatchesDefinition(plan, line, FloatView(segments, normals));
      ExpectMatchesDefinition(plan, point, FloatView(segments, normals));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, Accuracy, ::testing::ValuesIn(Subjects()), SubjectName);

TEST(Backends, RequiredOnesAreHere) {
  for (const std::string& name : RequiredBackends()) {
    const auto backend = MakeBackendByName(name);
    ASSERT_TRUE(backend.ok()) << "LATTICED_REQUIRE_BACKENDS names " << name << ": "
                              << backend.status();
    EXPECT_EQ((*backend)->name(), name);
    EXPECT_FALSE((*backend)->description().empty());
  }
}

}  // namespace
}  // namespace latticed::testing
