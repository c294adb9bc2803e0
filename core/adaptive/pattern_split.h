// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a patch is split, as a function of the levels of its edges alone.
//
// A point of the patch is three integers i that sum to N = 4096: its barycentrics times N. Corner c has i_c = N.
// The weight of a side from p to q is, with d = q - p and k_01, k_12, k_20 the levels of edges 0, 1 and 2,
//
//   w = |d_0 d_1| 4^k_01 + |d_1 d_2| 4^k_12 + |d_2 d_0| 4^k_20
//   w = - d_0 d_1 4^k_01 -  d_1 d_2 4^k_12 -  d_2 d_0 4^k_20      in the sparser pattern
//
// A side is split at its middle if w > N^2. Both triangles of a side therefore agree, and 2^k segments arise on an
// edge of level k. The middle has integer coordinates at all levels up to 5.
//
// Splitting begins with the triangle of corners 0, 1, 2 and repeats until no side is split. A triangle keeps its
// winding. m_pq is the middle of p and q.
//
//   split sides      the triangle (p, q, r) becomes
//   none             a triangle of the pattern
//   pq               (p, m_pq, r)  (m_pq, q, r)
//   qr and rp        (m_rp, m_qr, r), and the quadrilateral p, q, m_qr, m_rp, cut along its diagonal of smaller weight:
//                    p to m_qr: (p, q, m_qr)  (p, m_qr, m_rp)
//                    q to m_rp: (p, q, m_rp)  (q, m_qr, m_rp)
//                    where weights are equal: the diagonal from p if p > q in lexicographic order, else that from q
//   all              (p, m_pq, m_rp)  (m_pq, q, m_qr)  (m_rp, m_qr, r)  (m_pq, m_qr, m_rp)
//
// Threads  pure
#ifndef LATTICED_CORE_ADAPTIVE_PATTERN_SPLIT_H_
#define LATTICED_CORE_ADAPTIVE_PATTERN_SPLIT_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/adaptive/pattern_key.h"

namespace latticed {

inline constexpr int kSplitDenominator = 4096;

using SplitPoint = std::array<int32_t, 3>;  // barycentrics times kSplitDenominator
using SplitTriangle = std::array<SplitPoint, 3>;

// The triangles of the pattern, in no particular order.
[[nodiscard]] std::vector<SplitTriangle> SplitPatch(const PatternKey& key);

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_PATTERN_SPLIT_H_
