// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Moments of the surface at rest, one table for each knot box that holds patches. They turn integrals over the deformed
// surface into sums of products of a box's polynomial, whose cost does not depend on the number of patches.
//
//   moment[d](p, q, r) = integral of l_0^p l_1^q l_2^r over the box's patches at rest, by component d of the directed
//                        area element, in the box's coordinates l = (parameter - centre) / width
//
//   A triangle with corners a, b, c and directed area A has, with k = p + q + r,
//     moment[d](p, q, r) = A_d  2 p! q! r! / (k + 2)!  [z_0^p z_1^q z_2^r] 1 / ((1 - a.z)(1 - b.z)(1 - c.z)).
//   The series of each factor is a recurrence of three products for each term.
//              Baldoni, Berline, De Loera, Koeppe & Vergne 2011, doi:10.1090/S0025-5718-2010-02378-6
//
// kVolume has the powers up to 3 n on an axis of degree n, which the volume and its gradient need; kCentroid up to 4 n.
// For degrees (2, 2, 2) a box takes 8 and 17 KB, for (3, 3, 3) 24 and 53 KB.
//
// With vertex weights w, which are one more coordinate of a corner, there are tables for the volume alone, always of the
// order kVolume (weighted_volume.h), and only where they are worth it: where boxes have four patches each, and the tables
// take no more than kMostWeightedBytes. Their integrands have a factor w^s, and those of the last two families the
// components (a, w) of the directed area in place of (a + 1, a + 2):
//
//   family   0  1  2  3  4
//   s        1  2  3  1  2
//
// A box takes 41 KB for degrees (2, 2, 2), 120 KB for (3, 3, 3). The centroid of a weighted surface takes no moments, and
// neither does its volume where there are no tables, or any measure under turned lattices (patch_integrals.h).
//
// Layout   [family][d][p][q][r], double; one family without weights
// Errors   what `stop` returns
// Threads  immutable
#ifndef LATTICED_CORE_MEASURE_SURFACE_MOMENTS_H_
#define LATTICED_CORE_MEASURE_SURFACE_MOMENTS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/ffd/box/box_contraction.h"
#include "core/ffd/box/span_basis.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class SurfaceMoments {
 public:
  enum class Order : int { kVolume = 3, kCentroid = 4 };

  [[nodiscard]] static absl::StatusOr<std::shared_ptr<const SurfaceMoments>> Make(
      std::shared_ptr<const DeformPlan> plan, Order order, StopCheck stop = NeverStop);
  // The bytes that Make will take.
  [[nodiscard]] static size_t BytesFor(const DeformPlan& plan, Order order);

  const DeformPlan& plan() const { return *plan_; }
  Order order() const { return order_; }
  // Number of powers on each axis.
  const std::array<size_t, 3>& extent() const { return extent_; }
  // The knot boxes that hold patches, ascending. The outside box is not among them. None with turned lattices,
  // and if is_weighted() without tables.
  const std::vector<uint32_t>& boxes() const { return boxes_; }
  // Component d of the table of boxes()[n], of a family with weights. Up to kOverhang doubles behind it may be read.
  const double* table(size_t n, size_t d, size_t family = 0) const {
    return moments_.data() + ((n * families_ + family) * 3 + d) * terms();
  }
  // Whether there are none: measures are integrated patch by patch (patch_integrals.h).
  bool is_by_patches() const {
    return boxes_.empty() && (plan_->is_weighted() || !plan_->turned.empty());
  }
  // Whether there are tables with weights.
  bool has_weights() const { return families_ > 1; }
  // Of the whole surface, if has_weights().
  double rest_volume() const { return rest_volume_; }
  // Between the control points and the powers of l of boxes()[n]. Refers to these moments.
  BoxContraction contraction(size_t n) const {
    const std::array<int, 3>& span = plan_->boxes[boxes_[n]].span;
    const auto basis = [&](size_t a) { return &basis_[a][static_cast<size_t>(span[a])]; };
    return {plan_->structure, span, {basis(0), basis(1), basis(2)}};
  }
  // The sum over the patches outside the frame of (x . A) and of (x . A) c, with x a corner, c the centroid and A the
  // directed area, relative to the plan's local origin.
  double outside_volume() const { return outside_volume_; }
  Vec3d outside_centroid() const { return outside_centroid_; }
  size_t MemoryBytes() const { return BytesFor(*plan_, order_); }

  static constexpr size_t kOverhang = 8;
  static constexpr size_t kWeightedFamilies = 5;
  // As many as 3,000 boxes of degrees (2, 2, 2) take, or 1,000 of (3, 3, 3).
  static constexpr size_t kMostWeightedBytes = 128'000'000;

 private:
  SurfaceMoments(std::shared_ptr<const DeformPlan> plan, Order order);
  size_t terms() const { return extent_[0] * extent_[1] * extent_[2]; }
  absl::Status AddBox(size_t n, StopPoll& poll);
  void ScaleTables(double* tables) const;
  void AddOutside();
  void AddRestVolume();

  const std::shared_ptr<const DeformPlan> plan_;
  const Order order_;
  const size_t families_;
  std::array<size_t, 3> extent_{};
  std::array<std::vector<SpanBasis>, 3> basis_;  // by span; zero where it is empty
  std::vector<uint32_t> boxes_;
  std::vector<double> moments_;
  double outside_volume_ = 0, rest_volume_ = 0;
  Vec3d outside_centroid_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_SURFACE_MOMENTS_H_
