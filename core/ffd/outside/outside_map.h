// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Continues a lattice outside its frame: makes a larger lattice, the continued one, which is the given one inside the frame.
// Plans, kernels and certificates see the continued lattice alone, edits the given one.
//
//   displacements of the continued lattice = s E d,  E = E_w x E_v x E_u,  d = P - identity,  s = strength, 0 to 1
//
// E_a, for an axis of degree n whose first knot spans are h inside, and at the beginning of which W is the width and S the
// step; d_0, d_1, … are the given displacements (the end mirrors this):
//
//                 knots in front of h             control points in front of d_1
//   falloff, C1   -W (n + 1 times), -S, 0 (n - 1) n at rest, d_0 + S/h (d_0 - d_1)
//   falloff, C0   -W (n + 1 times), -S, 0 (n)     n at rest, t d_0, d_0;    t = 1 - smoothstep(S / (n W))
//   linear        -W (n + 1 times), 0 (n)         d_0 + k W/h (d_0 - d_1) for k = n … 1, d_0
//
// C1: the polar form of the first span at (-S, 0, …), so the span h has the same polynomial. n layers at rest end the move
// with n - 1 continuous derivatives. Linear: the Bézier points of the tangent. See Piegl & Tiller, The NURBS Book, §5.2 for
// the insertion of knots, of which C1 is the opposite.
//
// A control point of the continued lattice that depends on points at rest alone (bit for bit) is at its identity position,
// so that seams at rest stay attached.
//
// Layout   control points u fastest, as in lattice.h
// Errors   none: the structure must be valid
// Threads  immutable, once what others move is known
#ifndef LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_MAP_H_
#define LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_MAP_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/ffd/sum/knot_refinement.h"

namespace latticed {

class OutsideMap {
 public:
  explicit OutsideMap(const LatticeStructure& structure, double strength = 1);
  // The lattice as one of several, whose sum is planned: lattice_sum.h. `refined`: its part of the sum.
  OutsideMap(const LatticeStructure& structure, double strength, const LatticeStructure& sum,
             const RefinedAxes& refined);
  // The continued lattice as one of several of a plan: its control points are those from `first` on. `rest`: all control points
  // of the plan at rest. Continue, Moves, Moved and Apply then return numbers for all of them; ApplyTransposed takes
  // them, and ForSources their indices.
  void PlaceAmong(size_t first, std::shared_ptr<const std::vector<Vec3d>> rest);
  // Continue also adds what the other lattices move the control points of the plan.
  void AddOthers(std::shared_ptr<const std::vector<Vec3d>> moves) { others_ = std::move(moves); }

  // The same map with this strength.
  [[nodiscard]] OutsideMap At(double strength) const;

  // Whether both lattices are the same one.
  bool is_identity() const { return is_identity_; }
  double strength() const { return strength_; }
  // The given one's.
  const LatticeStructure& structure() const { return structure_; }
  // The continued one's. Its own `outside` is fixed.
  const LatticeStructure& continued() const { return continued_; }
  // The number of control points of the plan.
  size_t planned_count() const;

  // The control points of the continued lattice, from those of the given one.
  [[nodiscard]] std::vector<Vec3d> Continue(std::span<const Vec3d> control_points) const;
  // What this lattice moves the control points of the continued one: s E d.
  [[nodiscard]] std::vector<Vec3d> Moves(std::span<const Vec3d> control_points) const;
  // The continued lattice at rest, moved.
  [[nodiscard]] std::vector<Vec3d> Moved(std::span<const Vec3d> moves) const;
  // s E d, for moves or tangents of the given control points.
  [[nodiscard]] std::vector<Vec3d> Apply(std::span<const Vec3d> d) const;
  // s E' g, for derivatives by the continued control points.
  [[nodiscard]] std::vector<Vec3d> ApplyTransposed(std::span<const Vec3d> g) const;
  // Calls visit(given index, weight) for the control points on which the continued one with this index depends.
  template <typename Visit>
  void ForSources(size_t index, Visit visit) const;
  size_t MemoryBytes() const;

  // A row of E_a: at most two numbers that are not 0, in neighbouring columns; in a sum at most five.
  struct Row {
    int first = 0;  // column
    int count = 0;
    std::array<double, 5> weight{};
  };
  const std::vector<Row>& rows(size_t axis) const { return rows_[axis]; }

 private:
  // Sets what follows from the strength and from whether the lattice goes on.
  void TakeRest();

  LatticeStructure structure_;
  LatticeStructure continued_;
  double strength_;
  bool goes_on_ = false;  // the lattices differ, whatever the strength
  bool is_identity_ = true;
  std::array<std::vector<Row>, 3> rows_;
  std::vector<Vec3d> rest_;            // the given lattice's identity
  std::vector<Vec3d> continued_rest_;  // the continued one's; empty where plan_rest_ has it
  size_t first_ = 0;                   // of its control points, among those of the plan
  // Null where the continued lattice is all of the plan.
  std::shared_ptr<const std::vector<Vec3d>> plan_rest_;
  std::shared_ptr<const std::vector<Vec3d>> others_;
};

// As OutsideMap::At: `map` itself if it has the strength.
[[nodiscard]] std::shared_ptr<const OutsideMap> WithStrength(
    const std::shared_ptr<const OutsideMap>& map, double strength);

template <typename Visit>
void OutsideMap::ForSources(size_t index, Visit visit) const {
  if (index < first_ || index - first_ >= static_cast<size_t>(continued_.control_point_count())) {
    return;  // of another lattice
  }
  index -= first_;
  const auto size_u = static_cast<size_t>(continued_.size[0]);
  const auto size_v = static_cast<size_t>(continued_.size[1]);
  const Row& u = rows_[0][index % size_u];
  const Row& v = rows_[1][index / size_u % size_v];
  const Row& w = rows_[2][index / size_u / size_v];
  for (int k = 0; k < w.count; ++k) {
    for (int j = 0; j < v.count; ++j) {
      for (int i = 0; i < u.count; ++i) {
        visit(static_cast<size_t>(structure_.Index(u.first + i, v.first + j, w.first + k)),
              strength_ * (u.weight[static_cast<size_t>(i)] * v.weight[static_cast<size_t>(j)] *
                           w.weight[static_cast<size_t>(k)]));
      }
    }
  }
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_OUTSIDE_OUTSIDE_MAP_H_
