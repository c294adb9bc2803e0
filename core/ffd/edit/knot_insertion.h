// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Knot insertion for the whole volume.            Boehm 1980; Piegl & Tiller, The NURBS Book, §5.2
//
//   On the axis of degree p, for a new knot t in the span k (knots[k] <= t <= knots[k+1]):
//     Q_i = P_i                            i <= k - p
//     Q_i = (1 - a_i) P_{i-1} + a_i P_i    k - p < i <= k
//     Q_i = P_{i-1}                        i > k
//   with a_i = (t - knots[i]) / (knots[i+p] - knots[i])
//
// The volume keeps its shape to 1e-12 of its diagonal. A new point whose sources are all at rest (bit for bit at their
// identity positions) is put at its own identity position, so that seams at rest stay attached.
//
// Threads  pure
#ifndef LATTICED_CORE_FFD_EDIT_KNOT_INSERTION_H_
#define LATTICED_CORE_FFD_EDIT_KNOT_INSERTION_H_

#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/ffd/lattice.h"

namespace latticed {

// Errors: kInvalidArgument naming `field`.axis if it is not in 0…2; naming `field`.value if it is not finite, not
// strictly inside the domain, or there already as often as the degree allows; naming `field` if more than
// limits::kMaxControlPoints would result.
[[nodiscard]] absl::StatusOr<Lattice> WithKnotInserted(const Lattice& lattice, int axis,
                                                       double value, std::string_view field);

// The numbers a_i, for i from 0 to the axis' size: 1 where Q_i = P_i, 0 where Q_i = P_{i-1}. The insertion must be legal.
[[nodiscard]] std::vector<double> InsertionWeights(const LatticeStructure& structure, int axis,
                                                   double value);

// Inserts every knot of `structure` that the lattice lacks. `structure` must result from the lattice's by insertions.
[[nodiscard]] absl::StatusOr<Lattice> WithKnotsOf(const Lattice& lattice,
                                                  const LatticeStructure& structure);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_EDIT_KNOT_INSERTION_H_
