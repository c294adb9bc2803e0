// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The volume inside each knot box as a polynomial in power form about the box's centre, and the transposed map
// (core/ffd/box/box_contraction.h).
//
//   R(x) = origin + sum_pqr C_pqr l^p m^q n^r,   (l, m, n) as in local_map.h
//
// `origin` is one of the box's control points, so that C has no rounding of a far position.
//
//   sum of cotangents          S_pqr = sum over points of l^p m^q n^r g
//   gradient                   the transposed map of S
//
// Units    world units; l, m, n without unit
// Errors   none: the structure is valid and the spans are not empty
// Threads  immutable
#ifndef LATTICED_CORE_POINTS_BOX_MAP_H_
#define LATTICED_CORE_POINTS_BOX_MAP_H_

#include <array>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/box/box_contraction.h"
#include "core/ffd/box/box_polynomial.h"
#include "core/ffd/box/span_basis.h"
#include "core/ffd/lattice.h"
#include "core/points/local_map.h"

namespace latticed {

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
  // The same, added to add(number of the control point), which returns a Vec3d&.
  template <class Add>
  void AddTransposed(size_t box, const BoxNumbers& sums, const Add& add) const {
    ContractionOf(box).AddTransposed(sums, add);
  }

 private:
  struct Axis {
    int span = 0;
    double centre = 0, width = 1;
    SpanBasis basis{};
  };
  std::array<const Axis*, 3> AxesOf(size_t box) const;
  [[nodiscard]] BoxContraction ContractionOf(size_t box) const;

  const LatticeStructure structure_;
  std::array<std::vector<Axis>, 3> spans_;            // the non-empty ones
  std::array<std::vector<size_t>, 3> place_of_span_;  // by span
  std::array<Vec3d, 3> parameter_by_world_;           // rows
  Vec3d domain_begin_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_BOX_MAP_H_
