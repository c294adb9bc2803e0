// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/triangulate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/status_macros.h"
#include "core/mesh/corner_tree.h"

namespace latticed {
namespace {

using Point = PlanePoint;

// The polygon in its plane of best fit, counter-clockwise, relative to its first corner and scaled
// to a largest coordinate of 1: a distant or huge polygon keeps its digits and no product
// overflows.
std::vector<Point> Project(std::span<const Vec3d> polygon) {
  std::vector<Vec3d> local(polygon.size());
  double scale = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    local[i] =
        0.5 * polygon[i] - 0.5 * polygon[0];  // halved: the difference of two finite numbers fits
    scale = std::max({scale, std::abs(local[i].x), std::abs(local[i].y), std::abs(local[i].z)});
  }
  std::vector<Point> points(polygon.size());
  if (scale == 0) return points;
  for (Vec3d& p : local) p = p / scale;

  Vec3d normal = NewellNormal(local);
  const double length = Norm(normal);
  normal = length > 0 ? normal / length : Vec3d{0, 0, 1};
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(normal[i]) < std::abs(normal[axis])) axis = i;
  }
  Vec3d e;
  e[axis] = 1;
  Vec3d tangent = Cross(e, normal);
  tangent = tangent / Norm(tangent);
  const Vec3d bitangent = Cross(normal, tangent);
  for (size_t i = 0; i < local.size(); ++i) {
    points[i] = {Dot(local[i], tangent), Dot(local[i], bitangent)};
  }
  return points;
}

// The corners that may be an ear: a bit each, so that the next one in the order of the polygon is found fast.
class Candidates {
 public:
  explicit Candidates(uint32_t corners) : words_((corners + 63) / 64, ~uint64_t{0}) {
    if (corners % 64 != 0) words_.back() = (uint64_t{1} << (corners % 64)) - 1;
  }

  void Add(uint32_t corner) { words_[corner / 64] |= uint64_t{1} << (corner % 64); }
  void Remove(uint32_t corner) { words_[corner / 64] &= ~(uint64_t{1} << (corner % 64)); }

  // The first one at or after `corner`, cyclically; `corners` if there is none.
  uint32_t Next(uint32_t corner, uint32_t corners) const {
    size_t w = corner / 64;
    uint64_t word = words_[w] & (~uint64_t{0} << (corner % 64));
    for (size_t looked = 0; word == 0; ++looked) {
      if (looked == words_.size()) return corners;
      w = w + 1 == words_.size() ? 0 : w + 1;
      word = words_[w];
    }
    return static_cast<uint32_t>(w * 64 + static_cast<size_t>(std::countr_zero(word)));
  }

 private:
  std::vector<uint64_t> words_;
};

// Clips the next ear in the order of the polygon, again and again. A corner that is no ear is tried again only when
// what kept it from being one has changed: its neighbours, or the corner that lay in its triangle.
class EarClipper {
 public:
  EarClipper(const std::vector<Point>& points, StopCheck stop,
             std::vector<std::array<uint32_t, 3>>* triangles)
      : points_(points),
        stop_(stop),
        tree_(points),
        candidates_(Count()),
        corners_(points.size()),
        triangles_(*triangles) {
    const uint32_t n = Count();
    for (uint32_t i = 0; i < n; ++i) {
      corners_[i].previous = i == 0 ? n - 1 : i - 1;
      corners_[i].next = i + 1 == n ? 0 : i + 1;
    }
    for (uint32_t i = 0; i < n; ++i) UpdateBlocking(i);
  }

  absl::Status Run() {
    uint32_t corner = 0;
    for (uint32_t left = Count(); left > 3; --left) {
      LATTICED_ASSIGN_OR_RETURN(corner, NextToClip(corner));
      const uint32_t after = corners_[corner].next;
      Clip(corner);
      corner =
          corners_[after].next;  // not `after`: skipping one keeps the triangles from forming a fan
    }
    triangles_.push_back({corners_[corner].previous, corner, corners_[corner].next});
    return absl::OkStatus();
  }

 private:
  static constexpr uint32_t kNone = CornerTree::kNone;
  // Doubled area, in the unit box of Project, below which a corner counts as flat: rounding of the
  // projection.
  static constexpr double kFlat = 4e-15;
  static constexpr uint64_t kTestsPerStopCheck = uint64_t{1} << 15;
  // A smaller polygon may take as many tests as one of this many corners.
  static constexpr uint64_t kSmallPolygon = 512;

  struct Corner {
    uint32_t previous = 0, next = 0;
    bool blocking = false;  // reflex or flat: cannot be an ear, may lie in one
    bool touching = false;  // lies on a corner of a waiting triangle, so its own edges decide, too
    // Corners that are no ears because this one lies in their triangles, as a list.
    uint32_t first_waiting = kNone;
    // The list that this corner is in.
    uint32_t waits_for = kNone, waiting_before = kNone, waiting_after = kNone;
  };

  uint32_t Count() const { return static_cast<uint32_t>(points_.size()); }

  double Area(uint32_t i) const {
    return Orient(points_[corners_[i].previous], points_[i], points_[corners_[i].next]);
  }

  absl::StatusOr<uint32_t> NextToClip(uint32_t start) {
    for (uint32_t i = start;; i = corners_[i].next) {
      LATTICED_RETURN_IF_ERROR(CheckWork());
      i = candidates_.Next(i, Count());
      if (i == Count()) return LeastBadCorner(start);
      if (IsEar(i)) return i;
    }
  }

  absl::Status CheckWork() {
    if (tests_ < next_check_) return absl::OkStatus();
    next_check_ = tests_ + kTestsPerStopCheck;
    if (tests_ > kMaxTestsPerCorner * std::max<uint64_t>(points_.size(), kSmallPolygon)) {
      return absl::InvalidArgumentError(
          "it takes too long to triangulate: too many of its corners are at one place or along one "
          "edge");
    }
    return stop_();
  }

  // A corner that is no ear is no candidate afterwards.
  bool IsEar(uint32_t i) {
    ++tests_;
    if (corners_[i].blocking) {
      candidates_.Remove(i);
      return false;
    }
    const uint32_t before = corners_[i].previous, after = corners_[i].next;
    const Point a = points_[before], b = points_[i], c = points_[after];
    const uint32_t found = tree_.FindIn(
        a, b, c,
        [&](uint32_t p) { return p != before && p != i && p != after && Blocks(p, a, b, c); },
        tests_);
    if (found == kNone) return true;
    candidates_.Remove(i);
    WaitFor(i, found);
    const Point q = points_[found];
    corners_[found].touching |= q == a || q == b || q == c;
    return false;
  }

  // Whether corner p lies in the triangle abc, its edges included. A corner at the place of a, b or
  // c (a bridge to a hole doubles corners) blocks only if the polygon goes from there into the
  // triangle.
  bool Blocks(uint32_t p, Point a, Point b, Point c) const {
    const Point q = points_[p];
    if (q == a) return EntersWedge(p, c, a, b);
    if (q == b) return EntersWedge(p, a, b, c);
    if (q == c) return EntersWedge(p, b, c, a);
    return Orient(a, b, q) >= -kFlat && Orient(b, c, q) >= -kFlat && Orient(c, a, q) >= -kFlat;
  }

  // Whether an edge at p, which lies on apex, points strictly between apex→left and apex→right,
  // with right counter-clockwise before left.
  bool EntersWedge(uint32_t p, Point left, Point apex, Point right) const {
    const auto inside = [&](Point q) {
      return Orient(apex, right, q) > kFlat && Orient(left, apex, q) > kFlat;
    };
    return inside(points_[corners_[p].previous]) || inside(points_[corners_[p].next]);
  }

  // Called where no corner is an ear: the rest crosses itself or is flat. Clipping a flat corner
  // does the least harm, then a convex one. Of equally bad ones it is the next from `start` on.
  uint32_t LeastBadCorner(uint32_t start) {
    if (by_cost_.empty()) {
      uint32_t i = start;
      do {
        by_cost_.emplace(Cost(i), i);
        i = corners_[i].next;
      } while (i != start);
    }
    const double least = by_cost_.begin()->first;
    const auto from_start = by_cost_.lower_bound({least, start});
    return from_start != by_cost_.end() && from_start->first == least ? from_start->second
                                                                      : by_cost_.begin()->second;
  }

  double Cost(uint32_t i) const {
    const double area = Area(i);
    const double reflex_penalty = area < -kFlat ? 8.0 : 0.0;  // above any area of the unit box
    return std::abs(area) + reflex_penalty;
  }

  void Clip(uint32_t i) {
    const uint32_t before = corners_[i].previous, after = corners_[i].next;
    triangles_.push_back({before, i, after});
    const bool ranked = !by_cost_.empty();
    if (ranked) {
      for (const uint32_t corner : {before, i, after}) by_cost_.erase({Cost(corner), corner});
    }
    corners_[before].next = after;
    corners_[after].previous = before;
    if (ranked) {
      for (const uint32_t corner : {before, after}) by_cost_.emplace(Cost(corner), corner);
    }
    candidates_.Remove(i);
    StopWaiting(i);
    if (corners_[i].blocking) {
      tree_.Remove(i);
      WakeWaiting(i);
    }
    for (const uint32_t corner : {before, after}) {
      UpdateBlocking(corner);
      candidates_.Add(corner);
    }
  }

  void UpdateBlocking(uint32_t i) {
    if (corners_[i].touching) WakeWaiting(i);
    const bool blocking = Area(i) <= kFlat;
    if (blocking == corners_[i].blocking) return;
    corners_[i].blocking = blocking;
    blocking ? tree_.Add(i) : tree_.Remove(i);
    if (!blocking) WakeWaiting(i);
  }

  void WaitFor(uint32_t i, uint32_t blocker) {
    StopWaiting(i);
    Corner& corner = corners_[i];
    corner.waits_for = blocker;
    corner.waiting_before = kNone;
    corner.waiting_after = corners_[blocker].first_waiting;
    if (corner.waiting_after != kNone) corners_[corner.waiting_after].waiting_before = i;
    corners_[blocker].first_waiting = i;
  }

  void StopWaiting(uint32_t i) {
    Corner& corner = corners_[i];
    if (corner.waits_for == kNone) return;
    uint32_t& link = corner.waiting_before == kNone ? corners_[corner.waits_for].first_waiting
                                                    : corners_[corner.waiting_before].waiting_after;
    link = corner.waiting_after;
    if (corner.waiting_after != kNone) {
      corners_[corner.waiting_after].waiting_before = corner.waiting_before;
    }
    corner.waits_for = kNone;
  }

  void WakeWaiting(uint32_t blocker) {
    uint32_t i = std::exchange(corners_[blocker].first_waiting, kNone);
    corners_[blocker].touching = false;
    while (i != kNone) {
      candidates_.Add(i);
      corners_[i].waits_for = kNone;
      i = corners_[i].waiting_after;
    }
  }

  const std::vector<Point>& points_;
  const StopCheck stop_;
  CornerTree tree_;
  Candidates candidates_;
  std::vector<Corner> corners_;
  std::set<std::pair<double, uint32_t>> by_cost_;  // empty until no corner was an ear
  uint64_t tests_ = 0, next_check_ = kTestsPerStopCheck;
  std::vector<std::array<uint32_t, 3>>& triangles_;
};

// Both diagonals of a convex quadrilateral divide it. Of a concave one, only the diagonal from the reflex corner does.
void TriangulateQuad(std::span<const Vec3d> p, std::vector<std::array<uint32_t, 3>>* triangles) {
  const Vec3d normal = NewellNormal(p);
  const auto smaller_part = [&](size_t a, size_t b, size_t c, size_t d) {
    return std::min(Dot(normal, Cross(p[b] - p[a], p[c] - p[a])),
                    Dot(normal, Cross(p[c] - p[a], p[d] - p[a])));
  };
  const double part02 = smaller_part(0, 1, 2, 3);
  const double part13 = smaller_part(1, 2, 3, 0);
  const bool both_divide = part02 > 0 && part13 > 0;
  const bool use02 = both_divide ? Norm(p[2] - p[0]) <= Norm(p[3] - p[1]) : part02 >= part13;
  if (use02) {
    *triangles = {{0, 1, 2}, {0, 2, 3}};
  } else {
    *triangles = {{0, 1, 3}, {1, 2, 3}};
  }
}

}  // namespace

Vec3d NewellNormal(std::span<const Vec3d> polygon) {
  Vec3d normal;
  for (size_t i = 2; i < polygon.size(); ++i) {
    normal += Cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  }
  return normal;
}

absl::Status TriangulatePolygon(std::span<const Vec3d> polygon,
                                std::vector<std::array<uint32_t, 3>>* triangles, StopCheck stop) {
  triangles->clear();
  if (polygon.size() < 3) return absl::OkStatus();
  if (polygon.size() == 3) {
    triangles->push_back({0, 1, 2});
    return absl::OkStatus();
  }
  if (polygon.size() == 4) {
    TriangulateQuad(polygon, triangles);
    return absl::OkStatus();
  }
  const std::vector<Point> points = Project(polygon);
  triangles->reserve(polygon.size() - 2);
  return EarClipper(points, stop, triangles).Run();
}

}  // namespace latticed
