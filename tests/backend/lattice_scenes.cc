// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/lattice_scenes.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/ffd/outside/outside_map.h"
#include "core/ffd/outside/outside_rules.h"
#include "core/ffd/sum/lattice_groups.h"
#include "fmt/format.h"

namespace latticed::testing {
namespace {

// What all lattices of a group move the control points of their sum, added to those at rest.
std::vector<Vec3d> PointsOfGroup(const LatticeGroup& group,
                                 std::span<const LatticeStructure> structures,
                                 std::span<const std::vector<Vec3d>> points,
                                 std::span<const LatticeInScene> lattices) {
  std::vector<Vec3d> result = IdentityControlPoints(group.sum.structure);
  for (size_t i = 0; i < group.members.size(); ++i) {
    const size_t k = group.members[i];
    const OutsideMap map(structures[k], lattices[k].strength, group.sum.structure,
                         group.sum.parts[i]);
    const std::vector<Vec3d> moves = map.Moves(points[k]);
    for (size_t n = 0; n < result.size(); ++n) {
      // As OutsideMap::Moved: what rests keeps its bits.
      if (moves[n] != Vec3d{}) result[n] += moves[n];
    }
  }
  return result;
}

struct Planned {
  std::vector<LatticeStructure> structures;  // the first one, then those turned against it
  std::vector<Vec3d> points;                 // of all
};

absl::StatusOr<Planned> PlanAll(std::span<const LatticeStructure> structures,
                                std::span<const std::vector<Vec3d>> points,
                                std::span<const LatticeInScene> lattices, const PolygonMesh& mesh) {
  if (structures.size() == 1) {
    const OutsideMap map(structures[0], lattices[0].strength);
    return Planned{{map.continued()}, map.Continue(points[0])};
  }
  const auto groups = GroupLattices(structures, mesh.positions);
  if (!groups.ok()) return groups.status();
  Planned result;
  for (const LatticeGroup& group : *groups) {
    result.structures.push_back(group.sum.structure);
    const std::vector<Vec3d> own = PointsOfGroup(group, structures, points, lattices);
    result.points.insert(result.points.end(), own.begin(), own.end());
  }
  return result;
}

}  // namespace

Outside GoesOn(OutsideMode mode, bool smooth, const std::array<double, 6>& widths) {
  return {.mode = mode, .smooth = smooth, .widths = widths, .steps = {}};
}

std::array<int, 3> MixOfDegrees(int n) { return {1 + n % 3, 1 + n / 3 % 3, 1 + n / 9}; }

DeformedPoint LatticeScene::At(size_t patch, const std::array<double, 3>& b) const {
  const auto& vertices = plan->patches[patch].vertex;
  Vec3d x, middle;
  for (size_t c = 0; c < 3; ++c) {
    x += b[c] * plan->vertices[vertices[c]].world;
    middle += plan->vertices[vertices[c]].world / 3.0;
  }
  DeformedPoint point = SumAt(lattices, x, middle);
  if (!plan->is_weighted()) return point;
  const std::array<double, 3> w = plan->CornerWeights(patch);
  Weigh(x, b[0] * w[0] + b[1] * w[1] + b[2] * w[2], plan->PatchWeightGradient(patch),
        point.position, point.jacobian);
  return point;
}

LatticeScene MakeLatticeScene(PolygonMesh mesh, std::span<const LatticeInScene> lattices,
                              VertexWeights weights) {
  LatticeScene scene;
  std::vector<LatticeStructure> structures;
  std::vector<std::vector<Vec3d>> points;
  for (const LatticeInScene& lattice : lattices) {
    LatticeStructure s = MakeStructure(mesh.ComputeBounds(), lattice.options);
    s.outside = lattice.outside;
    s.outside = ResolvedOutside(s, mesh.positions);
    EXPECT_OK(Validate(s));
    const auto seed = kLatticesSeed + static_cast<uint32_t>(structures.size());
    points.push_back(Jitter(s, lattice.noise, seed));
    scene.lattices.emplace_back(s, points.back(), lattice.strength);
    structures.push_back(std::move(s));
  }
  auto planned = PlanAll(structures, points, lattices, mesh);
  EXPECT_OK(planned);
  if (!planned.ok()) return scene;
  scene.points = std::move(planned->points);
  auto plan =
      MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), planned->structures[0], {},
               NeverStop, std::move(weights), std::span(planned->structures).subspan(1));
  EXPECT_OK(plan);
  if (plan.ok()) scene.plan = *plan;
  return scene;
}

void ExpectSameInDouble(const LatticeScene& scene) {
  ASSERT_NE(scene.plan, nullptr);
  const DirectFfd direct(*scene.plan, scene.points);
  double position = 0, jacobian = 0;
  Bounds deformed;
  for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
    for (const auto& b : {std::array{0.0, 1.0, 0.0}, {0.2, 0.3, 0.5}, {0.6, 0.0, 0.4}}) {
      const DeformedPoint by_plan = direct.EvaluatePosition(p, b), by_lattices = scene.At(p, b);
      deformed.Extend(by_lattices.position);
      position = std::max(position, Norm(by_plan.position - by_lattices.position));
      for (size_t c = 0; c < 3; ++c) {
        jacobian = std::max(jacobian, Norm(by_plan.jacobian[c] - by_lattices.jacobian[c]));
      }
    }
  }
  EXPECT_LE(position, kDoublePosition * deformed.diagonal()) << "seed " << kLatticesSeed;
  EXPECT_LE(jacobian, kDoubleJacobian) << "seed " << kLatticesSeed;
}

void LatticeSceneTest::ExpectAsDefined(const LatticeScene& scene, int variant) {
  ASSERT_NE(scene.plan, nullptr);
  const ViewSpec spec{.segments = kFewAndMany[static_cast<size_t>(variant % 2)],
                      .normals = variant / 2 % 2 == 0 ? NormalMode::kFacet : NormalMode::kSmooth,
                      .format = VertexFormat::kFloat32};
  SCOPED_TRACE(fmt::format("{} segments, {} normals, seed {}", spec.segments,
                           variant / 2 % 2 == 0 ? "facet" : "smooth", kLatticesSeed));
  const std::vector<ViewPoint> points = EvaluateAll(scene.plan, scene.points, spec);
  std::vector<uint32_t> patches(scene.plan->patches.size());
  std::iota(patches.begin(), patches.end(), 0u);
  const Definition definition(*scene.plan, scene.points, spec.segments, spec.normals,
                              std::move(patches),
                              [&scene](size_t patch, const auto& b) { return scene.At(patch, b); });
  ASSERT_OK(definition.Check(GetParam().pipeline, points));
  ASSERT_EQ(CountCracks(*scene.plan, scene.points, spec.segments, points), 0u);
}

}  // namespace latticed::testing
