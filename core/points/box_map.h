// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The volume inside one knot box as a polynomial in power form about the box's centre, and the transposed map.
//
//   R(x) = origin + sum_pqr C_pqr l^p m^q n^r,   (l, m, n) = scale (x - frame origin) + offset,   each in [-1/2, 1/2]
//   C_pqr = sum_ijk A[i][p] B[j][q] D[k][r] (P_ijk - origin)      A, B, D: span_basis.h of u, v, w
//
// `origin` is one of the box's control points, so that C has no rounding of a far position.
//
//   sum of cotangents          S_pqr = sum over points of l^p m^q n^r g
//   gradient                   dP_ijk = sum_pqr A[i][p] B[j][q] D[k][r] S_pqr
//
// Units    world units; l, m, n without unit
// Errors   none: the structure is valid and the spans are not empty
// Threads  immutable
#ifndef LATTICED_CORE_POINTS_BOX_MAP_H_
#define LATTICED_CORE_POINTS_BOX_MAP_H_

#include <array>
#include <span>
#include <vector>

#include "core/base/limits.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/ffd/span_basis.h"

namespace latticed {

inline constexpr size_t kPowers = limits::kMaxDegree + 1;

// Numbers for the powers l^p m^q n^r: coefficients, or sums. Zero beyond the degree.
struct BoxNumbers {
  double at[kPowers][kPowers][kPowers][3] = {};  // [p][q][r][component]
};

struct BoxPolynomial {
  Vec3d origin;
  BoxNumbers coefficients;
};

// (l, m, n) of a point of the world: number a is scale[a] . (x - frame_origin) + offset[a]. The rows `scale` are also
// d(l, m, n)/dx.
struct LocalMap {
  Vec3d frame_origin;
  std::array<Vec3d, 3> scale;
  Vec3d offset;
};

// The boxes of a structure. Box number: u fastest, over the non-empty spans.
class BoxMaps {
 public:
  explicit BoxMaps(const LatticeStructure& structure);

  const LatticeStructure& structure() const { return structure_; }
  size_t count() const { return spans_[0].size() * spans_[1].size() * spans_[2].size(); }
  size_t BoxOf(const std::array<int, 3>& span) const;
  [[nodiscard]] LocalMap MapOf(size_t box) const;
  // Of control points.
  [[nodiscard]] BoxPolynomial PolynomialOf(size_t box, std::span<const Vec3d> control_points) const;
  // Of velocities of control points: its origin is zero.
  [[nodiscard]] BoxPolynomial VelocityOf(size_t box, std::span<const Vec3d> tangents) const;
  // Adds what the sums of a box are for each control point.
  void AddGradient(size_t box, const BoxNumbers& sums, std::span<Vec3d> gradient) const;

 private:
  struct Axis {
    int span = 0;
    double centre = 0, width = 1;
    SpanBasis basis{};
  };
  std::array<const Axis*, 3> AxesOf(size_t box) const;
  [[nodiscard]] BoxPolynomial Contract(size_t box, std::span<const Vec3d> points,
                                       Vec3d origin) const;
  size_t FirstPoint(const std::array<const Axis*, 3>& axes) const;

  const LatticeStructure structure_;
  std::array<std::vector<Axis>, 3> spans_;            // the non-empty ones
  std::array<std::vector<size_t>, 3> place_of_span_;  // by span
  std::array<Vec3d, 3> parameter_by_world_;           // rows
  Vec3d domain_begin_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_BOX_MAP_H_
