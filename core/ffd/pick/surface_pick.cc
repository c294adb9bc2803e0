// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/pick/surface_pick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "core/base/bounds.h"
#include "core/base/status_macros.h"
#include "core/ffd/box/bezier_box.h"
#include "core/ffd/carried_normal.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/pick/ray_frame.h"
#include "core/ffd/pick/volume_triangle.h"
#include "core/ffd/weights/weighted_triangle.h"

namespace latticed {
namespace {

constexpr int kMostIterations = 24;
// A patch with a smaller sine at its first corner is left out: its neighbours cover its points.
constexpr double kNoArea = 1e-12;

// A triangle inside a patch. `corners` are barycentrics in the patch.
struct Part {
  uint32_t patch = 0;
  std::array<Vec3d, 3> corners{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};

  Vec3d At(double s, double t) const {
    return corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]);
  }
};

// Bounds that hold on a whole part: of its position, and of its derivatives by s and t, which differ from `slope` by at
// most `spread`.
struct Reach {
  Bounds hull;
  Vec3d corner;  // s = t = 0
  std::array<Vec3d, 2> slope, spread;

  // Bounds by the mean value theorem, from `corner`. Their error falls with the square of the part's size. The error of
  // the Bézier hull falls with the size only, since the box around the part extends beyond the part's plane.
  Bounds MeanValueHull() const {
    Bounds mean;
    mean.Extend(corner);
    for (size_t e = 0; e < 2; ++e) {
      mean.Extend(corner + slope[e] - spread[e]);
      mean.Extend(corner + slope[e] + spread[e]);
    }
    return mean;
  }
  // Whether a line, seen along the ray, separates the ray from the part. The line runs along the longer derivative:
  // where the surface lies nearly along the ray, the part itself looks like a line.
  bool PassesBy(double distance) const {
    const auto across = [](Vec3d v) { return std::hypot(v.x, v.y); };
    const Vec3d along = across(slope[0]) > across(slope[1]) ? slope[0] : slope[1];
    const Vec3d normal = Vec3d{-along.y, along.x, 0} / across(along);
    const Vec3d extent{std::abs(normal.x), std::abs(normal.y), 0};
    double least = Dot(normal, corner), most = least;
    for (size_t e = 0; e < 2; ++e) {
      const double end = Dot(normal, corner + slope[e]), error = Dot(extent, spread[e]);
      least = std::min(least, end - error);
      most = std::max(most, end + error);
    }
    return least > distance || most < -distance;
  }

  // Whether (x, y) has at most one root in the part, even if (x, y) is off by `noise`.
  bool OneRootAtMost(double noise) const {
    const double det = slope[0].x * slope[1].y - slope[1].x * slope[0].y;
    const double x = spread[0].x + spread[1].x + noise, y = spread[0].y + spread[1].y + noise;
    const double s = std::abs(slope[1].y) * x + std::abs(slope[1].x) * y;
    const double t = std::abs(slope[0].y) * x + std::abs(slope[0].x) * y;
    return std::max(s, t) < 0.5 * std::abs(det);
  }
};

struct Step {
  double entry = 0;  // nothing in it has a lower z
  double layer = 0;  // of entry
  int depth = 0;     // of bisection; 0 for a node
  std::optional<uint32_t> node;
  Part part;  // without a node
};
// The order of steps: by layers of kTouch, and within a layer the deepest first. Where the surface lies across the ray,
// or on itself, the search then follows one part to its end instead of all of them in parallel.
struct Later {
  bool operator()(const Step& a, const Step& b) const {
    return std::pair(a.layer, -a.depth) > std::pair(b.layer, -b.depth);
  }
};

Bounds Plus(const Bounds& a, const Bounds& b) { return {a.min + b.min, a.max + b.max}; }

Bounds BoundsOf(std::span<const Vec3d> points) {
  Bounds bounds;
  for (const Vec3d p : points) bounds.Extend(p);
  return bounds;
}

class Search {
 public:
  Search(const DeformPlan& plan, const PatchTree& tree, std::span<const Vec3d> control_points,
         const Ray& ray)
      : plan_(plan),
        tree_(tree),
        map_(plan.structure),
        frame_(ray, BoundsOf(control_points).center()) {
    const auto own = static_cast<size_t>(plan.structure.control_point_count());
    for (size_t i = 0; i < control_points.size(); ++i) {
      const Vec3d p = control_points[i];
      const bool is_offset = plan.is_weighted() || i >= own;
      control_points_.push_back(is_offset ? frame_.Turn(p - plan.identity_points[i])
                                          : frame_.ToRay(p));
    }
    for (const TurnedLattice& lattice : plan.turned) {
      Bounds moves{Vec3d{}, Vec3d{}};  // nothing outside its frame
      for (const Vec3d move : lattice.PointsOf(control_points_)) moves.Extend(move);
      turned_ = Plus(turned_, moves);
    }
  }

  absl::StatusOr<std::optional<SurfaceHit>> Run(StopCheck stop) {
    Begin();
    StopPoll poll(stop);
    while (!steps_.empty() && steps_.top().layer <= LayerOf(nearest_)) {
      LATTICED_RETURN_IF_ERROR(poll.Step());
      const Step step = steps_.top();
      steps_.pop();
      if (step.entry > nearest_) continue;
      step.node.has_value() ? Descend(tree_.node(*step.node)) : Bisect(step.part, step.depth + 1);
    }
    return hit_;
  }

 private:
  // The boundaries of layers are at no round number, because flat surfaces often lie at one.
  double LayerOf(double z) const { return touch_ > 0 ? std::floor(z / touch_ + 0.3819) : 0; }
  bool IsOutside(uint32_t patch) const { return plan_.patches[patch].box == plan_.outside_box(); }
  bool Misses(const Bounds& hull) const {
    return hull.min.x > reach_ || hull.max.x < -reach_ || hull.min.y > reach_ ||
           hull.max.y < -reach_ || hull.max.z < frame_.begin() - reach_ || hull.min.z > nearest_;
  }
  // Interpolates a field of the patch's vertices at a point with these barycentrics.
  template <typename Field>
  Vec3d Blend(const Part& part, Vec3d barycentrics, Field field) const {
    const auto& vertex = plan_.patches[part.patch].vertex;
    return barycentrics.x * field(plan_.vertices[vertex[0]]) +
           barycentrics.y * field(plan_.vertices[vertex[1]]) +
           barycentrics.z * field(plan_.vertices[vertex[2]]);
  }
  // A point in the ray's frame, with its derivatives by s and t.
  struct Point {
    Vec3d position;
    std::array<Vec3d, 2> slope;
  };

  void Begin() {
    Bounds all;
    std::vector<Bounds> hulls;
    for (const uint32_t root : tree_.roots()) {
      const PatchTree::Node& node = tree_.node(root);
      hulls.push_back(
          node.box == plan_.outside_box() || plan_.is_weighted()
              ? HullOf(node)
              : Plus(ControlHull(plan_.structure, control_points_, plan_.boxes[node.box].span),
                     turned_));
      all.Extend(hulls.back());
    }
    const Vec3d extent = all.extent();
    const double largest = std::max({extent.x, extent.y, extent.z});
    reach_ = kReach * largest;
    touch_ = kTouch * largest;
    for (size_t n = 0; n < hulls.size(); ++n) {
      if (Misses(hulls[n])) continue;
      const double entry = hulls[n].min.z;
      steps_.push({.entry = entry, .layer = LayerOf(entry), .node = tree_.roots()[n]});
    }
  }

  Bounds HullOf(const PatchTree::Node& node) const { return Plus(OwnHullOf(node), turned_); }
  // Without what turned lattices add.
  Bounds OwnHullOf(const PatchTree::Node& node) const {
    const bool outside = node.box == plan_.outside_box();
    Bounds hull, rest;
    if (!outside) {
      hull = RestrictVolume(plan_.structure, control_points_, plan_.boxes[node.box].span,
                            node.lower, node.upper)
                 .Hull();
      if (!plan_.is_weighted()) return hull;
    }
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p{(corner & 1) != 0 ? node.upper.x : node.lower.x,
                    (corner & 2) != 0 ? node.upper.y : node.lower.y,
                    (corner & 4) != 0 ? node.upper.z : node.lower.z};
      rest.Extend(frame_.ToRay(outside ? p : map_.ToWorld(p)));
    }
    return outside ? rest : WeightedHull(rest, hull, 0, 1);
  }

  void Descend(const PatchTree::Node& node) {
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      if (node.leaf) {
        if (HasArea(i)) Consider({.patch = i}, 1);
      } else if (const Bounds hull = HullOf(tree_.node(i)); !Misses(hull)) {
        steps_.push({.entry = hull.min.z, .layer = LayerOf(hull.min.z), .node = i});
      }
    }
  }

  bool HasArea(uint32_t patch) const {
    const auto& v = plan_.patches[patch].vertex;
    const Vec3d a = plan_.vertices[v[1]].world - plan_.vertices[v[0]].world;
    const Vec3d b = plan_.vertices[v[2]].world - plan_.vertices[v[0]].world;
    return Norm(Cross(a, b)) > kNoArea * Norm(a) * Norm(b);
  }

  // Interpolates a field of the patch's vertices at the part's corners.
  template <typename Field>
  std::array<Vec3d, 3> Corners(const Part& part, Field field) const {
    return {Blend(part, part.corners[0], field), Blend(part, part.corners[1], field),
            Blend(part, part.corners[2], field)};
  }
  std::array<Vec3d, 3> RestCorners(const Part& part) const {
    return Corners(part, [this](const PlanVertex& v) { return frame_.ToRay(v.world); });
  }
  // The part must be inside.
  VolumeTriangle OwnTriangle(const Part& part) const {
    return {plan_.structure, control_points_, plan_.boxes[plan_.patches[part.patch].box].span,
            Corners(part, [](const PlanVertex& v) { return v.parameter; })};
  }
  // Calls visit(triangle) for the turned lattices that move the part.
  template <typename Visit>
  void ForTurned(const Part& part, Visit visit) const {
    for (const TurnedLattice& lattice : plan_.turned) {
      const KnotSpans& spans = lattice.spans[part.patch];
      if (spans == kNoSpans) continue;
      const auto parameter = [&](const PlanVertex& v) {
        return lattice.parameters[static_cast<size_t>(&v - plan_.vertices.data())];
      };
      visit(VolumeTriangle{lattice.structure, lattice.PointsOf(control_points_), spans,
                           Corners(part, parameter)});
    }
  }

  // The plan must be weighted.
  WeightedTriangle TriangleOf(const Part& part) const {
    const std::array<double, 3> weights = plan_.CornerWeights(part.patch);
    WeightedTriangle triangle{.rest = RestCorners(part)};
    for (size_t c = 0; c < 3; ++c) {
      const Vec3d b = part.corners[c];
      triangle.weight[c] = b.x * weights[0] + b.y * weights[1] + b.z * weights[2];
    }
    return triangle;
  }

  Reach ReachOf(const Part& part) const {
    Reach reach{.hull = {Vec3d{}, Vec3d{}}};
    if (!IsOutside(part.patch)) {
      OwnTriangle(part).Bound(reach.hull, reach.slope, reach.spread);
    } else if (!plan_.is_weighted()) {
      const std::array<Vec3d, 3> rest = RestCorners(part);
      reach = {.hull = BoundsOf(rest), .slope = {rest[1] - rest[0], rest[2] - rest[0]}};
    }
    ForTurned(part, [&](const VolumeTriangle& triangle) {
      triangle.Bound(reach.hull, reach.slope, reach.spread);
    });
    if (plan_.is_weighted()) {  // up to here these are bounds of F - x
      const WeightedTriangle triangle = TriangleOf(part);
      for (size_t e = 0; e < 2; ++e) {
        triangle.BoundSlope(e, reach.hull, reach.slope[e], reach.spread[e]);
      }
      reach.hull = triangle.Hull(reach.hull);
    }
    reach.corner = Evaluate(part, 0, 0).position;
    const Bounds mean = reach.MeanValueHull();
    reach.hull.min = Max(reach.hull.min, mean.min);
    reach.hull.max = Min(reach.hull.max, mean.max);
    return reach;
  }

  void Consider(const Part& part, int depth) {
    const Reach reach = ReachOf(part);
    if (Misses(reach.hull) || reach.PassesBy(reach_)) return;
    const Vec3d extent = reach.hull.extent();
    if (std::max({extent.x, extent.y, extent.z}) <= touch_) {
      return Take(part, 1.0 / 3, 1.0 / 3, reach.hull.center().z, touch_);
    }
    if (reach.OneRootAtMost(reach_)) return FindRoot(part);
    const double entry = reach.hull.min.z;
    steps_.push({.entry = entry, .layer = LayerOf(entry), .depth = depth, .part = part});
  }

  // Bisects the edge that is the longest at rest.
  void Bisect(const Part& part, int depth) {
    const auto world = Corners(part, [](const PlanVertex& v) { return v.world; });
    size_t longest = 0;
    const auto length = [&world](size_t c) { return Norm(world[(c + 1) % 3] - world[c]); };
    for (size_t c = 1; c < 3; ++c) {
      if (length(c) > length(longest)) longest = c;
    }
    const size_t next = (longest + 1) % 3;
    const Vec3d middle = 0.5 * part.corners[longest] + 0.5 * part.corners[next];
    for (const size_t replaced : {longest, next}) {
      Part half = part;
      half.corners[replaced] = middle;
      Consider(half, depth);
    }
  }

  Point Evaluate(const Part& part, double s, double t) const {
    Point result{};
    if (!IsOutside(part.patch)) {
      OwnTriangle(part).Add(s, t, result.position, result.slope);
    } else if (!plan_.is_weighted()) {
      const std::array<Vec3d, 3> rest = RestCorners(part);
      result.slope = {rest[1] - rest[0], rest[2] - rest[0]};
      result.position = rest[0] + s * result.slope[0] + t * result.slope[1];
    }
    ForTurned(part, [&](const VolumeTriangle& triangle) {
      triangle.Add(s, t, result.position, result.slope);
    });
    if (plan_.is_weighted()) TriangleOf(part).Combine(s, t, result.position, result.slope);
    return result;
  }

  void FindRoot(const Part& part) {
    constexpr double kFarOutside = 4, kConverged = 1e-15;
    double s = 1.0 / 3, t = 1.0 / 3;
    for (int i = 0; i < kMostIterations; ++i) {
      const auto [p, slope] = Evaluate(part, s, t);
      const double det = slope[0].x * slope[1].y - slope[1].x * slope[0].y;
      const double ds = (slope[1].y * p.x - slope[1].x * p.y) / det;
      const double dt = (slope[0].x * p.y - slope[0].y * p.x) / det;
      s -= ds;
      t -= dt;
      if (!(std::abs(s) + std::abs(t) < kFarOutside)) return;
      if (std::abs(ds) + std::abs(dt) < kConverged) break;
    }
    std::array<double, 3> b{std::max(1 - s - t, 0.0), std::max(s, 0.0), std::max(t, 0.0)};
    const double sum = b[0] + b[1] + b[2];
    s = b[1] / sum;
    t = b[2] / sum;
    const Vec3d p = Evaluate(part, s, t).position;
    if (std::hypot(p.x, p.y) <= reach_) Take(part, s, t, p.z, 0);
  }

  // Takes a hit at z, which may be off by `uncertainty`.
  void Take(const Part& part, double s, double t, double z, double uncertainty) {
    if (z < frame_.begin() - reach_ || z - uncertainty >= nearest_) return;
    const Vec3d b = part.At(s, t);
    const double first = std::clamp(b.x, 0.0, 1.0), second = std::clamp(b.y, 0.0, 1.0 - first);
    nearest_ = z - uncertainty;
    hit_ = {.patch = part.patch, .barycentrics = {first, second, 1 - first - second}};
  }

  const DeformPlan& plan_;
  const PatchTree& tree_;
  const FrameMap map_;
  const RayFrame frame_;
  // In the ray's frame; with weights, and of turned lattices, their offsets.
  std::vector<Vec3d> control_points_;
  Bounds turned_{Vec3d{}, Vec3d{}};  // what turned lattices may add
  double reach_ = 0, touch_ = 0;     // world units
  std::priority_queue<Step, std::vector<Step>, Later> steps_;
  std::optional<SurfaceHit> hit_;
  // The least z that hit_ may have; another hit must have a lower one.
  double nearest_ = std::numeric_limits<double>::infinity();
};

}  // namespace

absl::StatusOr<std::optional<SurfaceHit>> PickSurface(const DeformPlan& plan, const PatchTree& tree,
                                                      std::span<const Vec3d> control_points,
                                                      const Ray& ray, StopCheck stop) {
  return Search(plan, tree, control_points, ray).Run(stop);
}

}  // namespace latticed
