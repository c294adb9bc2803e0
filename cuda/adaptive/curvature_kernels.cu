// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of the second derivatives of patches: one thread a patch composes the polynomial of its box with the patch's
// affine map, and takes the largest Bernstein coefficients. Twin of core/cpu/adaptive/kernel/adaptive_bounds-inl.h.
//
//   point(x, t) = centre + x along + t across      along = c1 - c0, across = c2 - (c0 + c1) / 2, c the corners
//
// With weights it composes the displacement and multiplies it by the weight.
//
// x = t = 0 is on the median, so the shear of core/adaptive/patch_curvature-inl.h is 1/2. At degree 8 and 9 a thread's
// numbers do not fit its registers; some are then in local memory.
#include "core/adaptive/curvature_slack.h"
#include "cuda/adaptive/adaptive_kernels.h"
#include "cuda/adaptive/store_bounds.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/fused/call_by_degree.h"
#include "cuda/fused/fused_coefficients.cuh"
#include "cuda/fused/fused_geometry.cuh"
#include "cuda/fused/fused_polynomial.cuh"

namespace latticed::kernels {
namespace {

constexpr float kMedianShear = 0.5f;

// By permuted axis, in coordinates of the patch's box.
struct MedianFrame {
  double centre[3], along[3], across[3];
};
__device__ __forceinline__ MedianFrame FrameOf(const FusedLaunch& launch,
                                               const DevicePatch& patch) {
  MedianFrame frame;
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    double corner[3];
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      corner[c] = LocalCoordinate(launch, launch.plan.vertices[patch.Vertex(c)], patch.Box(), i);
    }
    const double middle = 0.5 * (corner[0] + corner[1]);
    frame.centre[i] = 0.5 * (middle + corner[2]);
    frame.along[i] = corner[1] - corner[0];
    frame.across[i] = corner[2] - middle;
  }
  return frame;
}

__global__ void __launch_bounds__(kBlockThreads)
    ReachKernel(const __grid_constant__ AdaptiveLaunch launch) {
  const size_t index = Item();
  if (index >= launch.fused.patch_count) return;
  const DevicePatch patch = launch.fused.plan.patches[index];
  const MedianFrame frame = FrameOf(launch.fused, patch);
  for (int i = 0; i < 3; ++i) {
    // PatchReach of core/adaptive/curvature_slack.h.
    const double reach =
        fabs(frame.centre[i]) + 0.5 * fabs(frame.along[i]) + 0.5 * fabs(frame.across[i]);
    atomicMax(launch.state.reach + patch.Box() * 3 + i, __float_as_uint(__double2float_ru(reach)));
  }
}

// d^order l^k / dl^order for the powers k of an axis.
struct PowerSlopes {
  float of[limits::kMaxDegree + 1];
};
__device__ __forceinline__ PowerSlopes SlopesOf(float l, int order) {
  PowerSlopes slopes;
#pragma unroll
  for (int power = 0; power <= limits::kMaxDegree; ++power) {
    float value = power < order ? 0.0f : 1.0f;
    for (int k = 0; k < order; ++k) value *= static_cast<float>(power - k);
    for (int k = order; k < power; ++k) value *= l;
    slopes.of[power] = value;
  }
  return slopes;
}

// One thread for each of the sums of CurvatureSlack. All terms are positive, and the sums are rounded at most 40
// times, for which 4e-6 stands.
template <bool kWeighted>
__global__ void __launch_bounds__(kBlockThreads)
    SlackKernel(const __grid_constant__ AdaptiveLaunch launch) {
  const auto item = static_cast<uint32_t>(Item());
  constexpr uint32_t kSums = SlackSums(kWeighted);
  const uint32_t box = item / kSums, pair = item % kSums;
  if (box >= launch.fused.tables.box_count) return;
  const int* degree = launch.fused.tables.degree;
  const int stride = CoefficientStride(degree[0], degree[1], degree[2]);
  const float* x =
      launch.fused.polynomials.coefficients + size_t{box} * 3 * static_cast<size_t>(stride);
  PowerSlopes slopes[3];
#pragma unroll
  for (uint32_t a = 0; a < 3; ++a) {
    // Pairs 0, 1, 2 are second derivatives by one coordinate; pairs 3, 4, 5 by pair - 3 and the next one; with weights
    // 6, 7, 8 are first derivatives.
    const int order = pair < 3   ? (a == pair ? 2 : 0)
                      : pair < 6 ? (a == (pair - 2) % 3 || a == pair - 3)
                                 : a == pair - 6;
    slopes[a] = SlopesOf(__uint_as_float(launch.state.reach[box * 3 + a]), order);
  }
  float sum = 0;
  int k = 0;
#pragma unroll
  for (int a = 0; a <= limits::kMaxDegree; ++a) {
    if (a > degree[0]) break;
#pragma unroll
    for (int b = 0; b <= limits::kMaxDegree; ++b) {
      if (b > degree[1]) break;
      float row = 0;
#pragma unroll
      for (int c = 0; c <= limits::kMaxDegree; ++c) {
        if (c > degree[2]) break;
        const float norm = norm3df(x[k], x[stride + k], x[2 * stride + k]);
        row = fmaf(norm, slopes[2].of[c], row);
        ++k;
      }
      sum = fmaf(row, slopes[0].of[a] * slopes[1].of[b], sum);
    }
  }
  const int of_patch = degree[0] + degree[1] + degree[2] + (kWeighted ? 1 : 0);
  const auto roundings = static_cast<float>(13 * of_patch + 8);
  const float weight = pair < 3 ? 1.0f : 2.0f;
  launch.state.slack[item] = weight * (1 + 4e-6f) * 0x1p-24f * roundings * sum;
}

// The weight at x = t = 0, and its changes by x and t.
__device__ __forceinline__ void WeightOf(const PlanTables& plan, const DevicePatch& patch,
                                         float (&weight)[3]) {
  double corner[3];
#pragma unroll
  for (int c = 0; c < 3; ++c) corner[c] = plan.weights.vertices[patch.Vertex(c)];
  const double middle = 0.5 * (corner[0] + corner[1]);
  weight[0] = static_cast<float>(0.5 * (middle + corner[2]));
  weight[1] = static_cast<float>(corner[1] - corner[0]);
  weight[2] = static_cast<float>(corner[2] - middle);
}

template <int D0, int D1, int D2, bool kWeighted>
__global__ void __launch_bounds__(kBlockThreads)
    BoundsKernel(const __grid_constant__ AdaptiveLaunch launch) {
  constexpr int kSum = D0 + D1 + D2, kDegree = kSum + (kWeighted ? 1 : 0),
                kStride = CoefficientStride(D0, D1, D2);
  const size_t item = Item();
  if (item >= size_t{launch.fused.chunk_count} * kChunkPatches) return;
  const size_t place = item / kChunkPatches;
  const size_t chunk = launch.fused.chunks != nullptr ? launch.fused.chunks[place] : place;
  const size_t index = chunk * kChunkPatches + item % kChunkPatches;
  if (index >= launch.fused.patch_count) return;
  const DevicePatch patch = launch.fused.plan.patches[index];
  if (patch.Box() == launch.fused.plan.outside_box) {  // such a patch does not move
    StoreBounds(launch.state, index, {});
    return;
  }
  AffineMap<D2> map;
  float v[3];
  {
    const MedianFrame frame = FrameOf(launch.fused, patch);
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      map.l[i][0] = static_cast<float>(frame.centre[i]);
      map.l[i][1] = static_cast<float>(frame.along[i]);
      map.l[i][2] = static_cast<float>(frame.across[i]);
      v[i] = 2 * fabsf(map.l[i][1]) + fabsf(map.l[i][2]);
    }
  }
  map.FormPowers();
  float weight[3] = {1, 0, 0};
  if constexpr (kWeighted) WeightOf(launch.fused.plan, patch, weight);
  float composed[3][Terms(kDegree)];
#pragma unroll
  for (int component = 0; component < 3; ++component) {
    float c[kStride];
    LoadCoefficients<kStride>(launch.fused, patch.Box(), component, c);
    if constexpr (kWeighted) {
      constexpr float kNone[1] = {0};
      float displacement[Terms(kSum)];
      Composition<D0, D1, D2, false>::Compose(c, map, displacement, nullptr);
      MultiplyLinearAdd<kSum, 0>(displacement, weight, kNone, composed[component]);
    } else {
      Composition<D0, D1, D2, false>::Compose(c, map, composed[component], nullptr);
    }
  }
  const float* const p[3] = {composed[0], composed[1], composed[2]};
  CurvatureBounds<float> bounds = BoundCurvature<kDegree, float>(p, kMedianShear);
  const float* const slack = launch.state.slack + size_t{patch.Box()} * SlackSums(kWeighted);
  RaiseBounds(kWeighted ? WeightedPatchSlack(v, weight, slack) : PatchSlack(v, slack), &bounds);
  StoreBounds(launch.state, index, bounds);
}

}  // namespace

KernelCall ReachCall(const AdaptiveLaunch& launch) {
  return {ReachKernel, Order::kAfter, Blocks(launch.fused.patch_count), kBlockThreads, 0, launch};
}

KernelCall SlackCall(const AdaptiveLaunch& launch) {
  const bool weighted = launch.fused.plan.weights.vertices != nullptr;
  const size_t items = size_t{launch.fused.tables.box_count} * SlackSums(weighted);
  return {weighted ? SlackKernel<true> : SlackKernel<false>,
          Order::kAfter,
          Blocks(items),
          kBlockThreads,
          0,
          launch};
}

KernelCall BoundsCall(const AdaptiveLaunch& launch) {
  // One at least, which does nothing where a slice has no named chunk.
  const size_t patches = size_t{launch.fused.chunk_count} * kChunkPatches;
  const unsigned blocks = patches > 0 ? Blocks(patches) : 1;
  const bool weighted = launch.fused.plan.weights.vertices != nullptr;
  return CallByDegree(launch.fused.tables.degree, [&]<int D0, int D1, int D2> {
    const auto kernel =
        weighted ? &BoundsKernel<D0, D1, D2, true> : &BoundsKernel<D0, D1, D2, false>;
    return KernelCall(kernel, Order::kAfter, blocks, kBlockThreads, 0, launch);
  });
}

}  // namespace latticed::kernels
