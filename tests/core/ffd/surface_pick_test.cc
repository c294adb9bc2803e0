// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Picks, compared with the definition: the hit is a point of the exact surface on the ray, and no
// triangle of a fine tessellation is hit before it.
#include "core/ffd/pick/surface_pick.h"

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

constexpr double kOnRay = 1e-9;  // fraction of the diagonal, as SceneService.Pick promises

class Picker {
 public:
  Picker(PolygonMesh mesh, const LatticeStructure& structure, std::vector<Vec3d> control_points,
         VertexWeights weights = nullptr, std::span<const LatticeStructure> turned = {})
      : plan_(*MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure, {},
                        NeverStop, std::move(weights), turned)),
        tree_(*plan_),
        control_points_(std::move(control_points)),
        ffd_(*plan_, control_points_) {
    for (size_t p = 0; p < plan_->patches.size(); ++p) {
      for (const auto& b : {std::array{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}) {
        bounds_.Extend(At(p, b));
      }
    }
  }

  Vec3d At(size_t patch, std::array<double, 3> b) const {
    return ffd_.EvaluatePosition(patch, b).position;
  }
  // Returns the ray's parameter at the hit, or infinity if there is none.
  double Pick(const Ray& ray) {
    const auto hit = PickSurface(*plan_, tree_, control_points_, ray);
    EXPECT_OK(hit);
    if (!hit.ok() || !hit->has_value()) return std::numeric_limits<double>::infinity();
    last_ = **hit;
    double sum = 0;
    for (const double b : last_.barycentrics) {
      EXPECT_GE(b, 0);
      EXPECT_LE(b, 1);
      sum += b;
    }
    EXPECT_NEAR(sum, 1, 1e-15);
    const Vec3d d = At(last_.patch, last_.barycentrics) - ray.origin;
    const double along = Dot(d, ray.direction) / Dot(ray.direction, ray.direction);
    EXPECT_LE(Norm(d - along * ray.direction), kOnRay * bounds_.diagonal());
    EXPECT_GE(along * Norm(ray.direction), -kOnRay * bounds_.diagonal());
    return along;
  }

  const DeformPlan& plan() const { return *plan_; }
  const DirectFfd& ffd() const { return ffd_; }
  const Bounds& bounds() const { return bounds_; }  // of the corners of patches
  const SurfaceHit& last() const { return last_; }

 private:
  std::shared_ptr<const DeformPlan> plan_;
  PatchTree tree_;
  std::vector<Vec3d> control_points_;
  DirectFfd ffd_;
  Bounds bounds_;
  SurfaceHit last_;
};

constexpr int kSegments = 6;

// The points of every patch.
std::vector<Vec3d> Tessellate(const Picker& picker) {
  const auto& pattern = TessellationPattern::Get(kSegments);
  std::vector<Vec3d> points;
  for (size_t p = 0; p < picker.plan().patches.size(); ++p) {
    for (const auto& i : pattern.points) {
      points.push_back(
          picker.At(p, {1.0 * i[0] / kSegments, 1.0 * i[1] / kSegments, 1.0 * i[2] / kSegments}));
    }
  }
  return points;
}

// Newton's iteration from a point of the patch. Returns the ray's parameter where the ray's line
// meets the patch, or infinity if it does not meet it well inside and transversally.
double Refine(const Picker& picker, size_t patch, double s, double t, const Ray& ray) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto& v = picker.plan().patches[patch].vertex;
  const auto world = [&](size_t c) { return picker.plan().vertices[v[c]].world; };
  const std::array<Vec3d, 2> edges{world(1) - world(0), world(2) - world(0)};
  double along = 0;
  for (int i = 0; i < 30; ++i) {
    const DeformedPoint p = picker.ffd().EvaluatePosition(patch, {1 - s - t, s, t});
    std::array<Vec3d, 2> slope;
    for (size_t e = 0; e < 2; ++e) {
      for (int axis = 0; axis < 3; ++axis) {
        slope[e] += edges[e][axis] * p.jacobian[static_cast<size_t>(axis)];
      }
    }
    const Vec3d normal = Cross(slope[0], slope[1]);
    const double facing = Dot(normal, ray.direction);
    if (std::abs(facing) < 1e-4 * Norm(normal) * Norm(ray.direction)) return kNone;
    // p + ds slope0 + dt slope1 = origin + along direction, by Cramer's rule.
    const Vec3d d = ray.origin - p.position;
    const double ds = Dot(Cross(d, slope[1]), ray.direction) / facing;
    const double dt = Dot(Cross(slope[0], d), ray.direction) / facing;
    along = -Dot(normal, d) / facing;
    s += ds;
    t += dt;
    if (!(std::abs(s) + std::abs(t) < 3)) return kNone;
    if (i == 29 && std::abs(ds) + std::abs(dt) > 1e-12) return kNone;
  }
  constexpr double kInside = 1e-6;
  const bool inside = s > kInside && t > kInside && 1 - s - t > kInside;
  return inside && along > 0 ? along : kNone;
}

// The first root that Newton's iteration finds, started from each triangle that the ray meets or
// passes near.
double FirstRoot(const Picker& picker, const std::vector<Vec3d>& points, const Ray& ray) {
  constexpr double kNear = 0.2;  // in barycentrics
  const auto& pattern = TessellationPattern::Get(kSegments);
  const size_t per_patch = pattern.points.size();
  double first = std::numeric_limits<double>::infinity();
  for (size_t p = 0; p < picker.plan().patches.size(); ++p) {
    for (const auto& triangle : pattern.triangles) {
      const Vec3d a = points[p * per_patch + triangle[0]];
      const Vec3d e = points[p * per_patch + triangle[1]] - a;
      const Vec3d f = points[p * per_patch + triangle[2]] - a;
      const Vec3d h = Cross(ray.direction, f), d = ray.origin - a;
      const double det = Dot(e, h), b1 = Dot(d, h) / det;
      const double b2 = Dot(ray.direction, Cross(d, e)) / det;
      if (!(b1 > -kNear && b2 > -kNear && b1 + b2 < 1 + kNear)) continue;
      double s = 0, t = 0;
      const double b[3] = {1 - b1 - b2, b1, b2};
      for (size_t c = 0; c < 3; ++c) {
        s += b[c] * pattern.points[triangle[c]][1] / kSegments;
        t += b[c] * pattern.points[triangle[c]][2] / kSegments;
      }
      first = std::min(first, Refine(picker, p, s, t, ray));
    }
  }
  return first;
}

class Rays {
 public:
  explicit Rays(uint32_t seed) : random_(seed) {}
  double Unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  size_t Below(size_t n) { return std::min(n - 1, static_cast<size_t>(Unit() * double(n))); }
  Vec3d Direction() {
    while (true) {
      const Vec3d d{2 * Unit() - 1, 2 * Unit() - 1, 2 * Unit() - 1};
      if (const double length = Norm(d); length > 0.1 && length < 1) return d / length;
    }
  }
  Vec3d In(const Bounds& bounds) {
    const Vec3d e = bounds.extent();
    return bounds.min + Vec3d{Unit() * e.x, Unit() * e.y, Unit() * e.z};
  }

 private:
  std::mt19937 random_;
};

enum class Extra { kNothing, kWeights, kTurnedLattices, kBoth };

Picker Draw(uint32_t seed, Extra extra = Extra::kNothing) {
  const RandomCase drawn = DrawCase(seed);
  const LatticeStructure structure = MakeStructure(drawn.mesh.ComputeBounds(), drawn.options);
  std::vector<Vec3d> points = Jitter(structure, 0.15, seed);
  std::vector<LatticeStructure> turned;
  for (const double turn : {0.4, -1.3}) {
    if (extra != Extra::kTurnedLattices && extra != Extra::kBoth) break;
    LatticeOptions options = drawn.options;
    options.turn = turn;
    options.scale = 2.5;
    turned.push_back(MakeStructure(drawn.mesh.ComputeBounds(), options));
    const std::vector<Vec3d> own = Jitter(turned.back(), 0.05, seed);
    points.insert(points.end(), own.begin(), own.end());
  }
  VertexWeights weights;
  if (extra == Extra::kWeights || extra == Extra::kBoth) {
    Rays rays(seed);
    std::vector<float> values;
    for (size_t v = 0; v < drawn.mesh.positions.size(); ++v) {
      values.push_back(static_cast<float>(rays.Unit()));
    }
    weights = std::make_shared<const std::vector<float>>(std::move(values));
  }
  return Picker(drawn.mesh, structure, std::move(points), std::move(weights), turned);
}

void ExpectFirstRoots(Extra extra) {
  size_t hits = 0, misses = 0;
  for (uint32_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(seed);
    Picker picker = Draw(seed, extra);
    const std::vector<Vec3d> points = Tessellate(picker);
    Rays rays(seed);
    for (int i = 0; i < 40; ++i) {
      const Vec3d direction = (0.1 + 3 * rays.Unit()) * rays.Direction();
      const Ray ray{rays.In(picker.bounds()) - (i % 4 == 0 ? 0 : 2) * direction, direction};

      const double picked = picker.Pick(ray), first = FirstRoot(picker, points, ray);

      EXPECT_LE(picked, first + 1e-9 * picker.bounds().diagonal() / Norm(direction)) << i;
      ++(std::isfinite(picked) ? hits : misses);
    }
  }
  EXPECT_GT(hits, 200u);
  EXPECT_GT(misses, 100u);
}

TEST(SurfacePick, FindsTheFirstRootOfRandomRays) { ExpectFirstRoots(Extra::kNothing); }
TEST(SurfacePick, FindsTheFirstRootOnWeightedSurfaces) { ExpectFirstRoots(Extra::kWeights); }
TEST(SurfacePick, FindsTheFirstRootUnderTurnedLattices) {
  ExpectFirstRoots(Extra::kTurnedLattices);
}
TEST(SurfacePick, FindsTheFirstRootOnWeightedSurfacesUnderTurnedLattices) {
  ExpectFirstRoots(Extra::kBoth);
}

// A ray from outside through a point of the surface must hit at that point or before.
void ExpectNotPassed(Picker& picker, size_t patch, std::array<double, 3> b, Vec3d direction,
                     double slack) {
  const double away = 1.5 * picker.bounds().diagonal();
  const double picked = picker.Pick({picker.At(patch, b) - away * direction, direction});
  EXPECT_LE(picked, away + slack * picker.bounds().diagonal());
}

TEST(SurfacePick, NoRaySlipsThroughAnEdgeOrACorner) {
  for (uint32_t seed = 31; seed <= 42; ++seed) {
    SCOPED_TRACE(seed);
    Picker picker = Draw(seed);
    Rays rays(seed);
    for (int i = 0; i < 60; ++i) {
      const size_t patch = rays.Below(picker.plan().patches.size());
      std::array<double, 3> b{0, 0, 0};
      const double share = i % 3 == 0 ? 1 : rays.Unit();
      b[rays.Below(3)] = share;
      b[b[0] == share ? 1 : 0] += 1 - share;
      ExpectNotPassed(picker, patch, b, rays.Direction(), 1e-8);
    }
  }
}

TEST(SurfacePick, RaysThatOnlyTouchOrCutAtASmallAngle) {
  for (uint32_t seed = 51; seed <= 62; ++seed) {
    SCOPED_TRACE(seed);
    Picker picker = Draw(seed);
    Rays rays(seed);
    for (int i = 0; i < 40; ++i) {
      const size_t patch = rays.Below(picker.plan().patches.size());
      const std::array<double, 3> b{0.5, 0.25, 0.25};
      const Vec3d normal = picker.ffd().Evaluate(patch, b, DirectFfd::Normal::kFacet).normal;
      const Vec3d tangent = Unit(Cross(normal, rays.Direction()));
      const double angle = i % 2 == 0 ? 0 : std::pow(10, -1 - 6 * rays.Unit());
      // A curve of radius r is kTouch away from its tangent at sqrt(2 r kTouch) from the point.
      ExpectNotPassed(picker, patch, b, Unit(tangent + angle * normal), 1e-4);
    }
  }
}

TEST(SurfacePick, RaysAlongEdgesAndInThePlaneOfAFace) {
  const PolygonMesh cube = CubeMesh(3);
  const LatticeStructure structure = MakeStructure(cube.ComputeBounds(), {.scale = 1.2});
  Picker picker(cube, structure, IdentityControlPoints(structure));
  const double third = 1.0 / 3;
  for (const Vec3d origin : {Vec3d{-1, 0, 0}, {-1, third, 1}, {-1, 0.5, 1}, {-1, 1, third}}) {
    EXPECT_NEAR(picker.Pick({origin, {1, 0, 0}}), 1, 1e-8);
    EXPECT_NEAR(picker.Pick({{2, origin.y, origin.z}, {-2, 0, 0}}), 0.5, 1e-8);
  }
  EXPECT_NEAR(picker.Pick({{-1, -1, 0}, {1, 1, 0}}), 1, 1e-8) << "the diagonal of a face";
  EXPECT_FALSE(std::isfinite(picker.Pick({{-1, 0, 1 + 1e-6}, {1, 0, 0}})));
}

TEST(SurfacePick, TheHalfLineBeginsAtItsOrigin) {
  const PolygonMesh cube = CubeMesh(2);
  const LatticeStructure structure = MakeStructure(cube.ComputeBounds(), {.scale = 1.2});
  Picker picker(cube, structure, IdentityControlPoints(structure));
  EXPECT_NEAR(picker.Pick({{0.5, 0.4, 0.3}, {0, 0, 0.001}}), 700, 1e-9) << "from inside";
  EXPECT_NEAR(picker.Pick({{0.5, 0.4, 1}, {0, 0, 1}}), 0, 1e-12) << "on the surface";
  EXPECT_FALSE(std::isfinite(picker.Pick({{0.5, 0.4, 1.1}, {0, 0, 1}}))) << "away from it";
  EXPECT_NEAR(picker.Pick({{0.5, 0.4, 1e9}, {0, 0, -1}}), 1e9 - 1, 1e-6) << "from afar";
  EXPECT_NEAR(picker.Pick({{0.5, 0.4, -1}, {0, 0, 1e-100}}), 1e100, 1e88);
}

TEST(SurfacePick, CollapsedSurfaces) {
  const PolygonMesh torus = TorusMesh(24, 12);
  const LatticeStructure structure = MakeStructure(torus.ComputeBounds(), {.scale = 1.1});
  const auto picker_of = [&](Vec3d keep) {
    std::vector<Vec3d> points = IdentityControlPoints(structure);
    for (Vec3d& p : points) p = {keep.x * p.x, keep.y * p.y, keep.z * p.z};
    return Picker(torus, structure, points);
  };
  Picker flat = picker_of({1, 1, 0}), line = picker_of({1, 0, 0}), point = picker_of({0, 0, 0});

  EXPECT_NEAR(flat.Pick({{1, 0, 2}, {0, 0, -1}}), 2, 1e-9);
  EXPECT_NEAR(flat.Pick({{-3, 0, 0}, {1, 0, 0}}), 3 - 1.4, 1e-4) << "in its plane";
  EXPECT_NEAR(line.Pick({{0.3, 0, 2}, {0, 0, -1}}), 2, 1e-9);
  EXPECT_NEAR(line.Pick({{-3, 0, 0}, {1, 0, 0}}), 3 - 1.4, 1e-8);
  EXPECT_NEAR(point.Pick({{0, 0, 2}, {0, 0, -1}}), 2, 1e-9);
  EXPECT_FALSE(std::isfinite(point.Pick({{0.1, 0, 2}, {0, 0, -1}})));
}

TEST(SurfacePick, StopsWhenNobodyWaits) {
  const PolygonMesh cube = CubeMesh(2);
  const LatticeStructure structure = MakeStructure(cube.ComputeBounds(), {});
  const auto plan = *MakePlan(std::make_shared<const PolygonMesh>(cube), structure);
  const auto points = IdentityControlPoints(structure);

  const auto hit = PickSurface(*plan, PatchTree(*plan), points, {{0.5, 0.5, 3}, {0, 0, -1}},
                               [] { return absl::CancelledError("nobody waits"); });

  EXPECT_THAT(hit, StatusIs(absl::StatusCode::kCancelled));
}

}  // namespace
}  // namespace latticed::testing
