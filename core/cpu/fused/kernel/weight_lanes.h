// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the SIMD code needs beside fused_kernel.h where a mesh has weights (core/ffd/weights/vertex_weights.h). The polynomial
// of a box is then that of the offset G = F(x) - x, and the kernel combines
//
//   P = x + w G,   dP = dx + w dG + dw G
//
// at each point. x and w are affine over a patch.
//
// Layout  lane arrays as in fused_kernel.h; positions are relative to the local origin
// Threads pure functions on their arguments
#ifndef LATTICED_CORE_CPU_FUSED_KERNEL_WEIGHT_LANES_H_
#define LATTICED_CORE_CPU_FUSED_KERNEL_WEIGHT_LANES_H_

#include <array>

#include "core/cpu/fused/kernel/fused_kernel.h"

namespace latticed::fused {

// A point at rest, and its weight.
struct alignas(64) WeightedPoint {
  CornerLanes rest;
  Lanes weight;
};
struct alignas(64) WeightedEdge {
  WeightedPoint from, to;
};

// f(x, t) = center + x * along + t * across for f = (x, w), with the x and t of PatchLanes.
struct alignas(64) WeightedPatch {
  std::array<WeightedPoint, 3> corners;
  WeightedPoint center, along, across;
  CornerLanes facet;     // the unit facet normal at rest
  CornerLanes by_local;  // the gradient of w by box-local coordinates
  Lanes steepness;       // |grad w| in the world
  std::array<std::array<float, 3>, 3>
      rest_by_local;  // [coordinate][component]: dx / dl, the same for all lanes
};

// As EvaluateGroup, EvaluateEdges and EvaluateCorners, with weights.
void EvaluateWeightedGroup(GroupArguments& arguments, const WeightedPatch& weights);
void EvaluateWeightedEdges(const std::array<int, 3>& degree, const BoxPolynomial& box,
                           const EdgeLanes& edges, const WeightedEdge& weights, int segments,
                           float* out);
void EvaluateWeightedCorners(const std::array<int, 3>& degree, const BoxPolynomial& box,
                             const CornerLanes& corners, const WeightedPoint& weights, float* out);

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_WEIGHT_LANES_H_
