// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The few triangles of a pattern that decide its certificate.
//
// The bound of a side grows with each |d_a|, d the difference of its ends' barycentrics, and the bound of a triangle
// grows with the bounds of its sides (core/adaptive/certificate.h). A triangle is left out where another one has, side
// by side in some order, at least the same |d_a|.
//
// Threads  pure
#ifndef LATTICED_CORE_ADAPTIVE_LONGEST_TRIANGLES_H_
#define LATTICED_CORE_ADAPTIVE_LONGEST_TRIANGLES_H_

#include <vector>

#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/pattern_split.h"

namespace latticed {

[[nodiscard]] std::vector<PatternSides> LongestTriangles(
    const std::vector<SplitTriangle>& triangles);

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_LONGEST_TRIANGLES_H_
