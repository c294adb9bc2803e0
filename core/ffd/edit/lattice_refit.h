// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A lattice with other degrees, sizes or knots in the same frame, which deforms as much like a given one as it can.
//
//   min ∫ |R'(x) - R(x)|² dx over the frame
//
// This is the L2 projection of R onto the volumes of the new structure. It is separable: each axis is projected by
// itself, with its mass matrix, which is banded. The integrals are exact: Gauss's rule between all knots of both
// lattices. If the new volumes contain R (all its knots, degrees not lower), the shape stays the same to rounding.
//
// Displacements are projected, not positions. Where nothing has moved, the new points are therefore at their identity
// positions, bit for bit, and seams at rest stay attached.
//
// Threads  pure
#ifndef LATTICED_CORE_FFD_EDIT_LATTICE_REFIT_H_
#define LATTICED_CORE_FFD_EDIT_LATTICE_REFIT_H_

#include <cstddef>

#include "core/ffd/lattice.h"

namespace latticed {

inline constexpr size_t kMostResidualPlaces = size_t{1} << 19;  // a tenth of a second

struct LatticeRefit {
  Lattice lattice;
  // Largest distance between both deformations at the knots and half-way between them, in world units. Of more than
  // kMostResidualPlaces such places, a part that is spread over the frame.
  double residual = 0;
};

// `lattice` and `structure` are valid and have the same frame.
[[nodiscard]] LatticeRefit Refit(const Lattice& lattice, const LatticeStructure& structure);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_EDIT_LATTICE_REFIT_H_
