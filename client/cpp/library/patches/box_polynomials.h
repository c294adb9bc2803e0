// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomials that a client evaluates patches by, in float32, from control points in double.
//
//   position - origin = sum_ijk C_ijk l_0^i l_1^j l_2^k          l_a from -1/2 to 1/2
//   normal            = sum_a (conormal_a . n) (J_b x J_c)       J_a = d position / d l_a; (a, b, c) in cyclic order
//   at rest           = centre + sum_a l_a e_a - origin          of weighted plans
//
// conormal_a is width_a f_a of patches.proto, with the frame's sign, scaled for all boxes alike. The outside box has
// number 0; its conormals are 0, so that n itself shows. The knot box of spans (a, b, c) has number
// 1 + a + spans_0 (b + spans_1 c).
//
// Layout   floats by component: C_ijk at i + (d_0 + 1)(j + (d_1 + 1) k)
// Threads  one at a time calls Update
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_BOX_POLYNOMIALS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_BOX_POLYNOMIALS_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/box/span_basis.h"
#include "core/ffd/lattice.h"
#include "core/patches/patch_places.h"
#include "core/patches/patch_plan_parts.h"

namespace latticed::client {

// One box, as a view into BoxPolynomials.
struct BoxPolynomial {
  std::array<int, 3> degree{};
  const float* coefficients = nullptr;  // those of x, then y, then z
  const float* conormals = nullptr;     // conormal_0, conormal_1, conormal_2
  const float* rest = nullptr;          // centre - origin, e_0, e_1, e_2; null without weights
};

class BoxPolynomials {
 public:
  BoxPolynomials(const LatticeStructure& structure, const PatchPlanHeader& header);

  uint32_t spans(size_t axis) const { return spans_[axis]; }
  // The step of a box's number along an axis.
  uint32_t step(size_t axis) const { return steps_[axis]; }
  uint32_t Number(const std::array<uint32_t, 3>& spans) const {
    return 1 + spans[0] + steps_[1] * spans[1] + steps_[2] * spans[2];
  }
  uint32_t count() const { return 1 + steps_[2] * spans_[2]; }

  // Computes the polynomials of these knot boxes.
  void Update(std::span<const Vec3d> control_points, std::span<const uint32_t> boxes);

  // The most by which a position in these boxes, or in the outside box, differs from the exact one: patches.proto,
  // "Positions". World units, infinite where control points are not finite.
  [[nodiscard]] double PositionError(std::span<const uint32_t> boxes) const;

  BoxPolynomial operator[](uint32_t box) const {
    return {degree_, &coefficients_[box * 3 * terms_], &conormals_[box * 9],
            rest_.empty() ? nullptr : &rest_[box * 12]};
  }

 private:
  void SetOutside(const PatchPlanHeader& header);
  void SetConormals(const LatticeStructure& structure, const KnotPlanes& planes);
  void SetRest(const LatticeStructure& structure, const KnotPlanes& planes);
  void StoreRest(uint32_t box, size_t row, Vec3d numbers);
  std::array<uint32_t, 3> SpansOf(uint32_t box) const;
  // Of a box and a coordinate: the bound of sum_a |J_a|, and an interval that holds the coordinate.
  struct Reach {
    double derivatives = 0, lowest = 0, highest = 0;
    double offset = 0;  // of |R - X|, with weights
  };
  Reach WeightedReachOf(uint32_t box, size_t coordinate) const;
  Reach ReachOf(uint32_t box, size_t coordinate) const;
  void Store(uint32_t box, size_t term, Vec3d coefficient);

  std::array<int, 3> degree_, size_;
  std::array<uint32_t, 3> spans_, steps_;
  size_t terms_;
  Vec3d origin_;
  bool has_outside_;
  std::array<std::vector<SpanBasis>, 3> basis_;  // by axis, then by ordinal of the span
  std::array<std::vector<int>, 3> first_;        // the first control point that reaches a span
  std::vector<float> coefficients_, conormals_;
  std::vector<float> rest_;  // twelve for each box; empty without weights
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_BOX_POLYNOMIALS_H_
