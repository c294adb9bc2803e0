// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One of the lattices that a cell of the world is under: which of its knot boxes the cell meets, and what it adds to the
// Jacobian in each of them.
//
//   D_l = sum_a q_l[a] (R_a - e_a)        what it adds to F_l (jacobian_form.h): d (R_g - x) / d t_l
//         R_a, e_a: derivative and edge of a knot box by its coordinates (box_slopes.h)
//         q_l[a] = r_a . e_l: those of the cell's edge l
//
// In the lattice's parameters the cell is a parallelepiped. B is the part of its bounds in a knot box. R_a over B has
// Bernstein coefficients beside a linear function, and is no farther from it than they are. With the coordinates y in
// [-1, 1]^3 of B
//   R_a = C_a + sum_b y_b S_ab, within rho_a,   y_b = o_b + sum_k t_k q_k[b] / w_b,   w_b half the width of B
// Where the cell is much wider than B, y_b S_ab goes to the remainder. Shares of the remainder are laid to axes of the cell by
// how far they reach in the knot box, squared.
//
// Slack. With u = 2^-53, D_a the largest difference (box_determinant.h), Q_l[a] = p_a . |e_l| / width with moduli, k the
// condition (frame_gradients.h):
//   R_a 72 u D_a; e_a 4 u |e_a|; their difference, and that from the linear function 30 u (D_a + |e_a|);
//   q (8 + 5 k) u Q; products and sums 12 u          so (200 + 10 k) u Q_l[a] (D_a + |e_a|) is added
// The place of a cell in the lattice's parameters, in widths of its domain, is known to within
//   z_a = 64 (1 + k) u (1 + p_a . (m + |origin|)) + 2 kPlaneSnap
// where m bounds the moduli of all that c and e are sums of. B is wider by z, the cell's planes at knots have as much room,
// and z_b / w_b times S_ab is in the remainder. A cell that reaches across a plane by less than z counts as one that does
// not: the definition takes points within kPlaneSnap of a face of the frame to be on it, and the mesh is cut no closer to a
// knot plane. So lattices may have planes in common.
//
// Errors   none
// Threads  one at a time: what is known of knot boxes is kept
#ifndef LATTICED_CORE_FOLDS_VOLUME_LATTICE_H_
#define LATTICED_CORE_FOLDS_VOLUME_LATTICE_H_

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/folds/frame_gradients.h"
#include "core/folds/jacobian_form.h"

namespace latticed {

// A parallelepiped in the world.
struct WorldCell {
  Vec3d centre;
  std::array<Vec3d, 3> half;  // half its edges: e of jacobian_form.h
  Vec3d size;                 // m: the moduli of what the centre comes from
};

// What a lattice adds in the part of a cell inside planes.
struct VolumePiece {
  JacobianForm form;
  std::array<CellPlane, 6> planes;
  size_t plane_count = 0;
};

class VolumeLattice {
 public:
  // A cell in the lattice's parameters.
  struct View {
    Vec3d centre;
    std::array<Vec3d, 3> half;
    Vec3d room;                      // z, in parameters
    Vec3d lower, upper;              // the bounds, wider by z
    Vec3d inner_lower, inner_upper;  // the bounds, narrower by z
    std::array<int, 3> first, last;  // knot spans that those meet; empty ones between do not count
    bool meets = false;              // whether they meet any
    bool leaves = false;             // whether they leave the frame
  };

  // `at_rest`: the identity points, of which those of `points` that differ have moved.
  VolumeLattice(const LatticeStructure& structure, std::span<const Vec3d> points,
                std::span<const Vec3d> at_rest);

  const LatticeStructure& structure() const { return structure_; }
  // The part of the knot boxes between parameters.
  WorldCell CellBetween(Vec3d lower, Vec3d upper) const;
  View Look(const WorldCell& cell) const;
  // Whether a control point moves something in the spans.
  bool Moves(const View& view) const;
  bool Moves(const std::array<int, 3>& span) const { return moved_[PlaceOf(span)]; }
  // A bound of |J_g - I| there.
  double Rise(const View& view);
  // The number of pieces that AddPieces adds.
  size_t PieceCount(const View& view) const;
  void AddPieces(const WorldCell& cell, const View& view, std::vector<VolumePiece>& pieces) const;
  // Beyond the frame alone, where the lattice adds nothing: one piece for each face that the cell may cross.
  void AddBeyond(const View& view, std::vector<VolumePiece>& pieces) const;
  // In one span, between parameters, without planes.
  JacobianForm FormBetween(const WorldCell& cell, const View& view, const std::array<int, 3>& span,
                           Vec3d lower, Vec3d upper) const;
  // How many knot spans the cell's edge k crosses, at most, about.
  double Crossed(const View& view, size_t k) const;

  [[nodiscard]] static size_t MostBytes(const LatticeStructure& structure);

 private:
  bool IsEmpty(size_t axis, int span) const {
    const auto at = static_cast<size_t>(span);
    return !(structure_.knots[axis][at + 1] > structure_.knots[axis][at]);
  }
  size_t PlaceOf(const std::array<int, 3>& span) const;
  // Calls visit(span) for each knot box that the bounds meet, until it returns false.
  template <typename Visit>
  void ForEachSpan(const View& view, Visit visit) const;

  const LatticeStructure& structure_;
  std::span<const Vec3d> points_;
  FrameMap map_;
  FrameGradients frame_;
  std::vector<bool> moved_;    // by span
  std::vector<double> rises_;  // by span, kUnknown where none was asked for
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_VOLUME_LATTICE_H_
