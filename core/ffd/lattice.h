// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The B-spline volume.                                   Cui & Feng 2014, formula (1)
//
//   R(u,v,w) = sum_ijk P_ijk N_i(u) N_j(v) N_k(w)
//
//   degree 1..3 and size (control points) per axis, size > degree; size + degree + 1 knots, finite, non-decreasing,
//   interior multiplicity <= degree, others <= degree + 1; domain [knot_degree, knot_size], closed. The frame is a
//   parallelepiped in the world, right- or left-handed, that maps affinely to the domain.
//
// Layout  control points in world coordinates, u fastest: index = i + size_u (j + size_v k)
// Errors  kInvalidArgument naming the field ("lattice.knots_u", "lattice.control_points", …)
// Threads plain data and pure functions
#ifndef LATTICED_CORE_FFD_LATTICE_H_
#define LATTICED_CORE_FFD_LATTICE_H_

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/bounds.h"
#include "core/base/vec.h"
#include "core/ffd/outside/outside.h"

namespace latticed {

// Origin and three edge vectors of the lattice's rest box in the world.
struct LatticeFrame {
  Vec3d origin;
  std::array<Vec3d, 3> edges;
  friend bool operator==(const LatticeFrame&, const LatticeFrame&) = default;
};

// A lattice without its control points. A plan depends on nothing else of a lattice.
struct LatticeStructure {
  std::array<int, 3> degree{2, 2, 2};
  std::array<int, 3> size{4, 4, 4};
  std::array<std::vector<double>, 3> knots;
  LatticeFrame frame;
  Outside outside;

  int control_point_count() const { return size[0] * size[1] * size[2]; }
  int patch_degree() const { return degree[0] + degree[1] + degree[2]; }
  int Index(int i, int j, int k) const { return i + size[0] * (j + size[1] * k); }
  double domain_begin(int axis) const {
    return knots[static_cast<size_t>(axis)][static_cast<size_t>(degree[static_cast<size_t>(axis)])];
  }
  double domain_end(int axis) const {
    return knots[static_cast<size_t>(axis)][static_cast<size_t>(size[static_cast<size_t>(axis)])];
  }
  friend bool operator==(const LatticeStructure&, const LatticeStructure&) = default;
};

struct Lattice {
  LatticeStructure structure;
  std::vector<Vec3d> control_points;
};

// 0,…,0, 1, 2, …, m,…,m with m = size - degree and the ends repeated degree + 1 times.
[[nodiscard]] std::vector<double> ClampedUniformKnots(int degree, int size);
// Returns `given`, or clamped uniform knots if it is empty. An illegal degree or size allocates nothing: the result is
// empty, and Validate reports the error.
[[nodiscard]] std::vector<double> KnotsOrDefault(std::span<const double> given, int degree,
                                                 int size);
// Reads the flat list x y z x y z … of at most `most` finite points. kInvalidArgument names `field`.
[[nodiscard]] absl::StatusOr<std::vector<Vec3d>> PointsFromFlat(std::span<const double> flat,
                                                                size_t most,
                                                                std::string_view field);

[[nodiscard]] absl::Status Validate(const LatticeStructure& structure);
// Checks the structure, and the number and range of the control points, also of those outside.
[[nodiscard]] absl::Status Validate(const Lattice& lattice);

// Control points at the Greville abscissae: R is then the affine map of the frame, and the mesh is at rest.
[[nodiscard]] std::vector<Vec3d> IdentityControlPoints(const LatticeStructure& structure);

inline constexpr double kDefaultPadding = 0.05;  // of a LatticeFit that sets none

// Returns an axis-aligned identity lattice around `bounds`. Every side is moved out by `padding` times the longest edge
// of the bounds, so that flat meshes have a volume. A flat mesh with padding 0 is refused. kInvalidArgument names
// fit.size, fit.degree or fit.padding.
[[nodiscard]] absl::StatusOr<Lattice> FitLattice(const Bounds& bounds, std::array<int, 3> size,
                                                 std::array<int, 3> degree, double padding);

// Maps between world and parameter space, by the frame. Construct it once and use it for many points.
class FrameMap {
 public:
  explicit FrameMap(const LatticeStructure& structure);
  Vec3d ToParameter(Vec3d world) const;
  Vec3d ToWorld(Vec3d parameter) const;
  // The linear part of the map, for directions.
  Vec3d DirectionToParameter(Vec3d world) const;

 private:
  Vec3d origin_, begin_;
  std::array<Vec3d, 3> columns_;  // d world / d parameter
  std::array<Vec3d, 3> rows_;     // d parameter / d world
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_LATTICE_H_
