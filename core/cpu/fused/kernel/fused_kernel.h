// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The data that the SIMD code of the fused pipeline works on. A group is 16 patches (or edges, or corners) of one
// knot box, one per lane. Unused lanes repeat the last used one. Axes are permuted so that degrees fall
// (degree[0] >= degree[1] >= degree[2]): 10 instances of the code serve all 27 combinations of degrees.
//
// Box-local coordinates: (parameter - box centre) / box width, in [-1/2, 1/2].
// Layout  lane arrays are [field][16] floats, 64-byte aligned
// Threads pure functions on their arguments
#ifndef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_KERNEL_H_
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_KERNEL_H_

#include <array>
#include <cstddef>
#include <cstdint>

namespace latticed::fused {

// The other form composes the polynomials of a patch and of its edges, which takes 2,100 multiply-adds at
// degree 2 x 2 x 2, and collapses them, 100 for each row. A point then takes 110 to 120 fewer than where R is evaluated at
// each point. The two forms therefore break even between 5 and 6 segments, as measured in tests/bench/results/cpu.md.
inline constexpr int kMostDirectSegments = 5;

inline constexpr size_t kLanes = 16;
using Lanes = std::array<float, kLanes>;

// sum_abc coefficient[(a (d1+1) + b)(d2+1) + c][component] l0^a l1^b l2^c
struct alignas(64) BoxPolynomial {
  std::array<std::array<float, 3>, 64> coefficient;
  // An upper bound of the spectral norm of cof J in the box. Normals that are much shorter are ill-conditioned.
  float cofactor_bound = 0;
  // Only with weights, where the polynomial is that of an offset: upper bounds of the Frobenius norm of its
  // Jacobian, and of its length.
  float slope_bound = 0, offset_bound = 0;
  // Likewise: the position at rest is rest[0] + sum_i rest[1 + i] l_i, relative to the local origin. [term][component]
  std::array<std::array<float, 3>, 4> rest{};
};

// In box-local coordinates.
struct alignas(64) CornerLanes {
  std::array<Lanes, 3> point;
};
struct alignas(64) EdgeLanes {
  CornerLanes from, to;
};

// point(x, t) = center + x * along + t * across, with x = b1 + shear * b2 - 1/2, t = b2 - 1/2. `along` is the edge
// from corner 0 to corner 1, over which the patch lies: 0 <= shear <= 1. `across` is the perpendicular from that edge to
// corner 2, in the plane of the source triangle.
struct alignas(64) PatchLanes {
  std::array<CornerLanes, 3> corners;
  // Of the facet normal; see BoxPolynomials::LocalConormal.
  std::array<Lanes, 3> conormal;
  std::array<Lanes, 3> center, along, across;
  Lanes shear;
  Lanes along_length;    // world length of `along`
  Lanes inverse_height;  // 1 / world length of `across`
};

// For smooth normals. `facet` is the facet normal f as a direction in box-local coordinates. `normal` holds the vertex
// normal N of each corner as (N.f / |along|, N.a, N.c / |along|); a and c are the unit vectors of `along` and `across`.
struct alignas(64) SmoothLanes {
  std::array<Lanes, 3> facet;
  std::array<std::array<Lanes, 3>, 3> normal;    // [component][corner]
  std::array<std::array<Lanes, 3>, 3> conormal;  // [component][corner]
};

// The vertices of one group before they are stored: row[component][point] has 16 lanes. The components are x y z
// relative to the local origin, then the unit normal.
struct GroupScratch {
  float* rows = nullptr;  // 64-byte aligned
  size_t points = 0;
  float* Row(size_t component, size_t point) const {
    return rows + (component * points + point) * kLanes;
  }
};

// A point whose normal must come from the definition.
struct WeakNormal {
  uint16_t point, lane;
};

struct GroupArguments {
  std::array<int, 3> degree;
  int segments;
  const BoxPolynomial* box;
  const PatchLanes* patches;
  const SmoothLanes* smooth;  // null unless smooth normals are wanted
  bool normals;
  GroupScratch scratch;
  WeakNormal* weak;  // room for points * 16
  size_t weak_count;
};

// Evaluates all points of a group, its edges and corners included, from the group's own box.
void EvaluateGroup(GroupArguments& arguments);

// Evaluates the inner points of 16 edges: out[(k - 1) * 3 + component][lane] for k = 1 … segments - 1, from one end to
// the other.
void EvaluateEdges(const std::array<int, 3>& degree, const BoxPolynomial& box,
                   const EdgeLanes& edges, int segments, float* out);
// Evaluates 16 corners: out[component][lane].
void EvaluateCorners(const std::array<int, 3>& degree, const BoxPolynomial& box,
                     const CornerLanes& corners, float* out);

struct QuantiseArguments {
  GroupScratch scratch;
  std::array<float, 3> scale, offset;  // integer = round(p * scale + offset), clamped
  int position_bits;
  int normal_bits;  // 0: no normals
  size_t lanes;     // used lanes
  // Where the values of a lane's patch begin in each plane (x y z s t) of its chunk.
  std::array<std::array<uint8_t*, 5>, kLanes> destination;
};
// Rounds the rows of a group and stores them patch by patch.
void StoreQuantised(const QuantiseArguments& arguments);

// Interleaves the rows of a group patch by patch: destination[lane] gets points * components
// floats.
void StoreFloats(const GroupScratch& scratch, size_t components, size_t lanes,
                 const std::array<float*, kLanes>& destination);
// Stores the rows of a group as [point][component][lane]; `destination` is 64-byte aligned.
void StoreLaneOrder(const GroupScratch& scratch, size_t components, float* destination);

// Name of the instruction set that dispatch chose.
const char* TargetName();

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_KERNEL_H_
