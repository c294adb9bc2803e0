// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the SIMD code needs beside fused_kernel.h where a mesh has weights (core/ffd/weights/vertex_weights.h). The
// polynomial of a box is then that of the offset G = F(x) - x, and the kernel combines
//
//   P = x + w G,   dP = dx + w dG + dw G
//
// at each point, or with many segments the polynomial of P on each patch. x and w are affine over a patch. At corners,
// and between them, x is BoxPolynomial::rest of the same local coordinates as G, so that it takes no memory of its own.
//
// Layout  lane arrays as in fused_kernel.h; positions are relative to the local origin
// Threads pure functions on their arguments
#ifndef LATTICED_CORE_CPU_FUSED_KERNEL_WEIGHT_LANES_H_
#define LATTICED_CORE_CPU_FUSED_KERNEL_WEIGHT_LANES_H_

#include <array>

#include "core/cpu/fused/kernel/fused_kernel.h"

namespace latticed::fused {

struct alignas(64) CornerWeights {
  Lanes weight;
};
struct alignas(64) EdgeWeights {
  Lanes from, to;
};

// A position at rest and a weight, or their derivatives.
struct alignas(64) WeightedPoint {
  CornerLanes rest;
  Lanes weight;
};

// All that few segments need (fused_direct-inl.h): it has 16 patches in 448 bytes.
struct alignas(64) PatchWeights {
  std::array<Lanes, 3> corners;
  CornerLanes by_local;  // the gradient of w by box-local coordinates
  Lanes steepness;       // |grad w| in the world
};

// f(x, t) = center + x * along + t * across for f = (x, w), with the x and t of PatchLanes.
struct alignas(64) WeightedPatch {
  PatchWeights weights;
  WeightedPoint center, along, across;
  CornerLanes facet;  // the unit facet normal at rest
};

// As EvaluateGroup, EvaluateEdges and EvaluateCorners, with weights.
void EvaluateWeightedGroup(GroupArguments& arguments, const WeightedPatch& weights);
void EvaluateWeightedEdges(const std::array<int, 3>& degree, const BoxPolynomial& box,
                           const EdgeLanes& edges, const EdgeWeights& weights, int segments,
                           float* out);
void EvaluateWeightedCorners(const std::array<int, 3>& degree, const BoxPolynomial& box,
                             const CornerLanes& corners, const CornerWeights& weights, float* out);

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_WEIGHT_LANES_H_
