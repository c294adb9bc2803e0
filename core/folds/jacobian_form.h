// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The Jacobian over a cell, up to a remainder, and a lower bound of its determinant.
//
//   x(t) = c + sum_k t_k e_k,  |t_k| <= 1           the cell
//   F_l  = d F / d t_l = M_l + sum_k t_k L_lk + r_l,  |r_l| <= rho_l by component, at each t
//   det J = det(F_0, F_1, F_2) / det(e_0, e_1, e_2)
//
// With N = M^-1 and E = N (F - M), det(F) = det(M) det(I + E), and
//   det(I + E) = 1 + trace E + the three principal minors + det E
// The least value of what is linear in t is known exactly, also in the part of the cell inside a plane. Of squares and cubes,
// the moduli of coefficients are summed up, and of all that the remainder adds, the moduli of its terms. So the bound is within
// O(h^2) of the least det J in a cell of size h, however the deformation turns it. det M may have either sign: only the sum
// must be above 0.
//
// Slack. N need not be exact: N F = I + (N M - I) + N (F - M), and N M - I is computed and added to E. Where it is below 1/8,
// det N has the sign of det M, and so has the computed one. Products N v have errors of at most 5 u |N| |v| with moduli,
// u = 2^-53; 2^-48 (|M_l| + sum_k |L_lk|), added to rho_l, is six times that. The sums lose at most 100 u of the moduli of
// their terms, and 2^-40 of those is subtracted.
//
// Errors   none; where numbers overflow, nothing is proved
// Threads  plain data and pure functions
#ifndef LATTICED_CORE_FOLDS_JACOBIAN_FORM_H_
#define LATTICED_CORE_FOLDS_JACOBIAN_FORM_H_

#include <array>
#include <span>

#include "core/base/vec.h"

namespace latticed {

struct JacobianForm {
  std::array<Vec3d, 3> centre;  // M
  std::array<std::array<Vec3d, 3>, 3> slope,
      bend;  // L and rho, [l][k]: the share of rho_l that comes of t_k

  JacobianForm& operator+=(const JacobianForm& other);
};

// The part of the cell with normal . t <= bound.
struct CellPlane {
  Vec3d normal;
  double bound = 0;
};

struct DeterminantBound {
  double least = 0;  // infinity where the part is empty, NaN where numbers overflow
  Vec3d place;       // t where the linear part is least
  Vec3d loss;        // what each axis of the cell costs the bound, about
};

// In the part of the cell that is inside all planes. `rest`: det(e).
[[nodiscard]] DeterminantBound BoundDeterminant(const JacobianForm& form, double rest,
                                                std::span<const CellPlane> planes);

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_JACOBIAN_FORM_H_
