// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The SIMD code of views with a tolerance. It bounds the second derivatives of patches, evaluates points of any patches of
// one box side by side, and rounds them.
//
//   place of a point   m + along d + up (c - m),   m = (a + b) / 2, d = b - a,   a, b, c corners of its patch
//
// A point on an edge has up = 0, and a corner a = b. Exchanging a and b changes the signs of d and along, exactly, so both
// patches of an edge get the same place, bit for bit. EvaluatePoint then does the same operations on it.
//
// Layout  lanes of 16 floats; rows of a run are 64-byte aligned, one entry per patch or point
// Threads pure functions on their arguments
#ifndef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_KERNEL_H_
#define LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_KERNEL_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/backend.h"
#include "core/base/limits.h"
#include "core/cpu/fused/kernel/fused_kernel.h"

namespace latticed::fused {

// 16 patches of one box. bounds[k][lane]: k = 0 … 2 along edge k, 3 … 5 along both edges that leave corner k - 3.
// Rounding is allowed for (core/adaptive/curvature_slack.h).
struct BoundArguments {
  std::array<int, 3> degree;
  const BoxPolynomial* box;
  std::array<float, 6> slack;  // of the box
  const PatchLanes* patches;
  std::array<Lanes, 6>* bounds;
};
void BoundGroup(const BoundArguments& arguments);

inline constexpr size_t kRunPatches = limits::kPatchesPerChunk;

// Patches, or edges and corners alone, of one box: at most kRunPatches.
struct alignas(64) RunPatches {
  using Row = std::array<float, kRunPatches>;
  // [axis][corner]. Facet normals take the conormal of corner 0.
  std::array<std::array<Row, 3>, 3> corners, conormals;
};

// A point by the corners of its patch: a | b << 2 | c << 4.
constexpr int32_t PlaceCode(int a, int b, int c) { return a | b << 2 | c << 4; }

// With vertex weights: PatchWeights (weight_lanes.h) by patch of the run.
struct alignas(64) RunWeights {
  std::array<RunPatches::Row, 3> weight;  // [corner]
  std::array<RunPatches::Row, 3> by_local;
  RunPatches::Row steepness;
};

// The points of a run, one entry each, padded to a multiple of 16 with entries that are evaluated and not used.
struct RunPoints {
  const int32_t* patch;  // in the run
  const int32_t* code;   // PlaceCode
  const float* along;
  const float* up;
};

struct RunArguments {
  std::array<int, 3> degree;
  const BoxPolynomial* box;
  const RunPatches* patches;
  NormalMode normals;
  RunPoints points;
  // points: the number of vectors of 16. Point i is entry i % 16 of Row(component, i / 16): component after component, the
  // points lie one after the other.
  GroupScratch scratch;
  WeakNormal* weak;  // room for one each; `point` is the vector
  size_t weak_count;
  const RunWeights* weights = nullptr;  // null: none
};
void EvaluateRun(RunArguments& arguments);
// The same where `weights` is not null.
void EvaluateWeightedRun(RunArguments& arguments);

// integer = round(p * scale + offset), clamped to 0 … 2^bits - 1. `to` need not be aligned.
void QuantisePositions(std::span<const float> row, float scale, float offset, int bits,
                       uint8_t* to);
// Draco's octahedral map; one byte a value for bits <= 8, else two. `rows`: x, y and z, each padded to a multiple of 16.
void QuantiseNormals(const std::array<const float*, 3>& rows, size_t count, int bits, uint8_t* s,
                     uint8_t* t);

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_KERNEL_H_
