// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The sums of a box (enclosed_volume.h), compiled once per instruction set. Sets differ in the last bits.
//
//   cross[d][k] = (grad F_{k+1} x grad F_{k+2})_d          a polynomial with powers up to 2 n on each axis
//   sums[k][c]  = sum over d and b of cross[d][k][b] moment[d][c + b]
//
//   offsets[a][k] = (F_a x F)_k, with F_a the derivative by axis a
//
// Layout   a term l_0^a l_1^b l_2^c of F at (a kSide + b) kSide + c, of the others at (a kWide + b) kRow + c
// Errors   none
// Threads  pure functions
#ifndef LATTICED_CORE_MEASURE_BOX_INTEGRAL_KERNEL_H_
#define LATTICED_CORE_MEASURE_BOX_INTEGRAL_KERNEL_H_

#include <array>
#include <cstddef>

#include "core/base/limits.h"

namespace latticed::box_integral {

inline constexpr size_t kSide = limits::kMaxDegree + 1;
inline constexpr size_t kWide = 2 * limits::kMaxDegree + 1;
inline constexpr size_t kRow = kWide + 1;  // whole vectors
constexpr size_t NarrowTerm(size_t a, size_t b, size_t c) { return (a * kSide + b) * kSide + c; }
constexpr size_t WideTerm(size_t a, size_t b, size_t c) { return (a * kWide + b) * kRow + c; }

using Narrow = std::array<double, kSide * kSide * kSide>;
using Wide = std::array<double, kWide * kWide * kRow>;
using CrossProducts = std::array<std::array<Wide, 3>, 3>;

// Calls body(a, b, c) for the terms l_0^a l_1^b l_2^c of F.
template <typename Body>
void ForTerms(const std::array<size_t, 3>& degree, const Body& body) {
  for (size_t a = 0; a <= degree[0]; ++a) {
    for (size_t b = 0; b <= degree[1]; ++b) {
      for (size_t c = 0; c <= degree[2]; ++c) body(a, b, c);
    }
  }
}

// Terms of F beyond the degree must be zero. `cross` is zero before.
void MultiplySlopes(const std::array<Narrow, 3>& f, const std::array<size_t, 3>& degree,
                    CrossProducts& cross);

// The same for `offsets`, which has powers up to 2 n, too.
void MultiplyOffsets(const std::array<Narrow, 3>& f, const std::array<size_t, 3>& degree,
                     CrossProducts& offsets);

// How many powers a component d of products has on each axis.
using Powers = std::array<std::array<size_t, 3>, 3>;
// Those of `cross`.
[[nodiscard]] Powers CrossPowers(const std::array<size_t, 3>& degree);

// The moments of a box.
struct Moments {
  std::array<const double*, 3> table{};
  std::array<size_t, 3> extent{};
};
// Sums for the powers c of each axis below `count`, which is at most kWide.
void SumMoments(const CrossProducts& cross, const Powers& powers, const Moments& moments,
                const std::array<size_t, 3>& count, std::array<Wide, 3>& sums);

}  // namespace latticed::box_integral

#endif  // LATTICED_CORE_MEASURE_BOX_INTEGRAL_KERNEL_H_
