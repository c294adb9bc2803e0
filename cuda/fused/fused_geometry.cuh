// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the fused kernels compute from the plan's tables in double, before they go on in float: the box
// that owns a point, box-local coordinates, the frame of a patch, which is accurate for slivers too, and
// which normals float can represent.
//
//   point(x, t) = centre + (x + shear t) along + t across,   x = b1 + b2/2 - 1/2,  t = b2 - 1/2
//
// `along` runs from corner 0 to corner 1, over which the patch lies; `across` is its perpendicular up to
// corner 2, in the plane of the *source* triangle: that plane is accurate however thin the patch is.
// Rows of constant t are symmetric about x = 0, so the points at x and -x share even and odd parts.
#ifndef LATTICED_CUDA_FUSED_FUSED_GEOMETRY_CUH_
#define LATTICED_CUDA_FUSED_FUSED_GEOMETRY_CUH_

#include <limits>

#include "core/ffd/carried_normal.h"
#include "core/ffd/weights/weight_change.h"
#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

constexpr int kLanes = 32;  // patches of a chunk, and threads of a warp
// A height below this fraction of the first edge is a rounding error: the perpendicular keeps its
// direction and gets this length.
constexpr double kSmallestHeight = 0x1p-40;
// A facet normal is perpendicular to the patch's edges, but for this. Otherwise it is one of rounding errors:
// the source triangle has no area.
constexpr double kMostTilt = 1e-7;
// Normals shorter than this fraction of their bound are computed by the definition, in double. So are all
// normals of a patch whose bound is not between the next two: squares or products could overflow or
// underflow in float.
constexpr double kWeakNormal = 1 / kMaxNormalCondition;
constexpr double kShortestNormal = 1e-30, kLongestNormal = 1e37;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Which normals of a patch float can represent, by the length that the products give them.
struct NormalRange {
  float weak_below;  // a normal whose |n|_1 is not above this, or NaN, is left to the definition
  float scale;       // times this, any other normal has a square that float can represent
};
// No normal is longer than `bound`, and no intermediate vector is longer than `largest`.
__device__ inline NormalRange RangeOfNormals(double bound, double largest) {
  // The kernels compare the L1 norm, which is up to sqrt(3) times the length.
  constexpr double kSqrt3 = 1.7320508075688773;
  const bool fits = bound >= kShortestNormal && bound <= kLongestNormal &&
                    largest <= kLongestNormal;  // false for NaN
  return {fits ? static_cast<float>(kSqrt3 * kWeakNormal * bound) : kInfinity,
          1 / static_cast<float>(bound)};
}

__device__ __forceinline__ float3 CrossProduct(float3 a, float3 b) {
  return {fmaf(a.y, b.z, -a.z * b.y), fmaf(a.z, b.x, -a.x * b.z), fmaf(a.x, b.y, -a.y * b.x)};
}

__device__ inline uint32_t SeamOf(const FusedTables& tables, uint32_t key) {
  uint32_t low = 0, high = tables.seam_use_count;
  while (high - low > 1) {
    const uint32_t middle = (low + high) / 2;
    (tables.seam_uses[middle].key <= key ? low : high) = middle;
  }
  return tables.seam_uses[low].seam;
}

// A corner (number 0..2) or edge (3..5) of a patch, and where to find the box that owns its points.
struct Slot {
  uint32_t patch;
  uint32_t box;
  uint32_t number;
  uint32_t steps;
  bool on_seam;
};
__device__ inline uint32_t OwnerOf(const FusedLaunch& launch, const Slot& slot) {
  if (slot.on_seam && launch.attached[SeamOf(launch.tables, slot.patch * 8 + slot.number)] != 0) {
    return launch.plan.outside_box;
  }
  uint32_t box = slot.box;
#pragma unroll
  for (int axis = 0; axis < 3; ++axis) {
    if ((slot.steps >> axis & 1) != 0) box -= launch.tables.box_stride[axis];
  }
  return box;
}

// Box-local coordinate i (permuted axis) of a vertex. The product is rounded: the difference of two
// coordinates must change only its sign when the ends of an edge are exchanged, and the compiler would
// otherwise form a fused multiply-add of one of them.
__device__ inline double LocalCoordinate(const FusedLaunch& launch, const DeviceVertex& vertex,
                                         uint32_t box, int i) {
  const int axis = launch.tables.axis[i];
  const FusedBox& b = launch.tables.boxes[box];
  const double* v = box == launch.plan.outside_box ? &vertex.world.x : &vertex.parameter.x;
  return __dmul_rn(v[axis] - (&b.centre.x)[axis], (&b.inverse_width.x)[axis]);
}

// A point at rest, from the world to the units of the output. Each coordinate is rounded once, whatever the compiler makes
// of it: the difference of two points must change only its sign when they are exchanged.
__device__ inline Vec3d RestPoint(const FusedLaunch& launch, Vec3d world) {
  const double scale = launch.polynomials.scale;
  const Vec3d& offset = launch.polynomials.offset;
  return {__fma_rn(scale, world.x, offset.x), __fma_rn(scale, world.y, offset.y),
          __fma_rn(scale, world.z, offset.z)};
}
// An upper bound of ||cof J|| with weights: half the squared Frobenius norm of J = I + w J_G + G grad(w)^T.
// `steepness`: |grad w| in the world. Reads the polynomials.
__device__ inline double WeightedCofactorBound(const FusedLaunch& launch, uint32_t box,
                                               double steepness) {
  constexpr double kSqrt3 = 1.7320508075688773;
  const BoxPolynomials& p = launch.polynomials;
  const double slope = sqrt(2 * double{p.cofactor_bounds[box]});
  const double norm = kSqrt3 * p.scale + slope + steepness * double{p.length_bounds[box]};
  return 0.5 * norm * norm;
}

// Rows of a chunk's frames in shared memory. A row has one float for each lane.
enum FrameRow {
  kCentre = 0,
  kAlong = 3,
  kAcross = 6,
  kShear = 9,
  kWeakBelow,  // this and the next: the patch's NormalRange
  kNormalScale,
  kFacetRows,
  kFacet = kFacetRows,         // direction of the facet normal; this and the next are smooth only
  kVertexNormal = kFacet + 3,  // [3 corners][3]: by facet normal, along and across; see CarryNormal
  kSmoothRows = kVertexNormal + 9,
};
template <bool kSmooth>
constexpr int kPlainRows = kSmooth ? kSmoothRows : kFacetRows;
// Rows that follow with weights, counted from kPlainRows. An affine function of the patch at rest has three:
// its value at the centre, and its changes along and across.
enum WeightRow {
  kRest = 0,  // of x, y and z in the units of the output
  kWeight = 9,
  kRestFacet = 12,  // the facet normal, times the scale of the output
  kWeightRows = 15,
};

// Vertex normals in the frame, as components n with cof(J) N |along| |across| =
//   n0 P_along x P_across + n1 P_across x P_facet + n2 P_facet x P_along.
__device__ inline void WriteSmoothRows(const FusedLaunch& launch, uint32_t patch, uint32_t box,
                                       Vec3d facet, Vec3d along, Vec3d across, float* rows,
                                       int lanes) {
  for (int i = 0; i < 3; ++i) {
    rows[(kFacet + i) * lanes] =
        static_cast<float>(Dot(launch.tables.boxes[box].gradient[i], facet));
  }
  for (int c = 0; c < 3; ++c) {
    const Vec3d n = ToDouble(launch.plan.corner_normals[patch].corner[c]);
    float* row = rows + (kVertexNormal + 3 * c) * lanes;
    row[0] = static_cast<float>(Dot(n, facet));
    row[lanes] = static_cast<float>(Dot(n, along));
    row[2 * lanes] = static_cast<float>(Dot(n, across));
  }
}

// The patch at rest: `centre` is relative to the local origin. `weight`: those of its corners. Returns how steeply the
// weight may change.
__device__ inline double WriteWeightRows(const FusedLaunch& launch, uint32_t patch, Vec3d facet,
                                         Vec3d centre, Vec3d along, Vec3d across, double shear,
                                         const double (&weight)[3], float* rows, int lanes) {
  const double scale = launch.polynomials.scale;
  const Vec3d gradient = launch.plan.weights.gradients[patch], rest = RestPoint(launch, centre);
  const double rise = WeightChange(Dot(gradient, along), weight[1] - weight[0]);
  const double climb = WeightChange(
      Dot(gradient, across), weight[2] - weight[0] - (shear + 0.5) * (weight[1] - weight[0]));
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    float* row = rows + (kRest + 3 * i) * lanes;
    row[0] = static_cast<float>((&rest.x)[i]);
    row[lanes] = static_cast<float>(scale * (&along.x)[i]);
    row[2 * lanes] = static_cast<float>(scale * (&across.x)[i]);
    rows[(kRestFacet + i) * lanes] = static_cast<float>(scale * (&facet.x)[i]);
  }
  float* row = rows + kWeight * lanes;
  row[0] = static_cast<float>(weight[0] + (0.5 + 0.5 * shear) * rise + 0.5 * climb);
  row[lanes] = static_cast<float>(rise);
  row[2 * lanes] = static_cast<float>(climb);
  return WeightSteepness(Norm(gradient), climb, Norm(across));
}

struct FrameSize {
  double length, height;  // of the patch's first edge, and of the patch over it
  double steepness;       // of the weight in the world; 0 without weights
};

// Writes all rows but the two of NormalRange. Reads only the plan. `corner`: the vertices of the patch;
// `facet`: its facet normal; `weight`: those of the corners.
template <bool kSmooth, bool kWeighted>
__device__ inline FrameSize WriteFrame(const FusedLaunch& launch, uint32_t patch, uint32_t box,
                                       Vec3d facet, const DeviceVertex* const (&corner)[3],
                                       const double (&weight)[3], float* rows, int lanes) {
  const Vec3d origin = corner[0]->world;
  const Vec3d side = corner[2]->world - origin;
  Vec3d along = corner[1]->world - origin;
  const double length2 = Dot(along, along), inverse = length2 > 0 ? rsqrt(length2) : 0.0;
  const double length = length2 * inverse;
  const double off = Dot(along, facet);
  const bool has_area = fabs(off) <= kMostTilt * length;
  // Rounding moves the ends of a very short edge out of the facet's plane; this puts its direction back.
  if (has_area) along -= off * facet;
  const double shear = Dot(side, along) * inverse * inverse - 0.5;
  // Without area the patch has height 0, which leaves its normals to the definition.
  double height = 0;
  Vec3d across = side - (shear + 0.5) * along;
  if (has_area) {
    const Vec3d unit = inverse * Cross(facet, along);
    height = fmax(Dot(side, unit), kSmallestHeight * length);
    across = height * unit;
  }
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    const Vec3d gradient = launch.tables.boxes[box].gradient[i];
    const double a = Dot(gradient, along), c = Dot(gradient, across);
    // Corner 0 is at x = -1/2, t = -1/2.
    const double centre =
        LocalCoordinate(launch, *corner[0], box, i) + (0.5 + 0.5 * shear) * a + 0.5 * c;
    rows[(kCentre + i) * lanes] = static_cast<float>(centre);
    rows[(kAlong + i) * lanes] = static_cast<float>(a);
    rows[(kAcross + i) * lanes] = static_cast<float>(c);
  }
  rows[kShear * lanes] = static_cast<float>(shear);
  if constexpr (kSmooth) {
    WriteSmoothRows(launch, patch, box, facet, along, across, rows, lanes);
  }
  double steepness = 0;
  if constexpr (kWeighted) {
    const Vec3d centre = origin + (0.5 + 0.5 * shear) * along + 0.5 * across;
    steepness = WriteWeightRows(launch, patch, facet, centre, along, across, shear, weight,
                                rows + kPlainRows<kSmooth> * lanes, lanes);
  }
  return {length, height, steepness};
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_GEOMETRY_CUH_
