// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Samples of the lattice at the m uniform points of each patch.      Cui & Feng 2014, §3.4
//
//   u_i = sum_c (t_ic / n) u_c,   t_i the index triples of bernstein.h, u_c the patch's corners
//
// Computed in double and stored relative to the patch's centre, so that float32 carries the shape
// of a patch without its position, as in core/cpu/gemm/patch_sampler.h. With weights, of x + w (R - x).
#include "cuda/device/launch.cuh"
#include "cuda/gemm/gemm_kernels.h"
#include "cuda/plan/plan_point.cuh"

namespace latticed::kernels {
namespace {

struct PatchCorners {
  bool outside;
  const int* span;
  Vec3d corner[3];  // parameters; world positions outside
};

__device__ PatchCorners Corners(const PlanTables& plan, size_t patch) {
  const DevicePatch p = plan.patches[patch];
  PatchCorners result;
  result.outside = p.Box() == plan.outside_box;
  result.span = plan.boxes[p.Box()].span;
  for (int c = 0; c < 3; ++c) {
    const DeviceVertex& vertex = plan.vertices[p.Vertex(c)];
    result.corner[c] = result.outside ? vertex.world : vertex.parameter;
  }
  return result;
}

__global__ void __launch_bounds__(kBlockThreads)
    CentreKernel(const __grid_constant__ Tile tile, Vec3d* centres) {
  const size_t i = Item();
  if (i >= tile.count) return;
  Vec3d sum;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    Vec3d corner;
    corner[c] = 1;
    sum += PlanPoint(tile.plan, tile.turned, tile.control_points, tile.first + i, corner);
  }
  centres[i] = sum / 3.0;
}

template <typename T>
__device__ void Store(T* column, size_t stride, Vec3d value) {
  column[0] = static_cast<T>(value.x);
  column[stride] = static_cast<T>(value.y);
  column[2 * stride] = static_cast<T>(value.z);
}

template <typename T, bool kByNormal>
__global__ void __launch_bounds__(kBlockThreads)
    SampleKernel(const __grid_constant__ Tile tile, Samples<T> samples) {
  const size_t i = Item(), m = static_cast<size_t>(samples.m), stride = m * tile.count;
  if (i >= stride) return;
  const size_t in_tile = i / m;
  const PatchCorners patch = Corners(tile.plan, tile.first + in_tile);
  const uchar4 t = samples.points[i % m];
  const double over = 1.0 / samples.degree;
  const Vec3d b{t.x * over, t.y * over, t.z * over};
  const Vec3d at = b.x * patch.corner[0] + b.y * patch.corner[1] + b.z * patch.corner[2];
  Vec3d jacobian[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3d position = at;
  if (!patch.outside) {
    const VolumePoint point =
        EvaluateVolume<kByNormal>(Volume(tile.plan, tile.control_points), patch.span, at);
    position = point.position;
    if constexpr (kByNormal) {
      WorldJacobian(point.derivatives, tile.plan.parameter_by_world, jacobian);
    }
  }
  AddTurned<kByNormal>(tile.plan, tile.turned, tile.control_points, tile.first + in_tile, b,
                       position, jacobian);
  Vec3d n, by_normal;
  if constexpr (kByNormal) {
    n = UnpackDirection(tile.plan.facet_normals[tile.first + in_tile]);
    by_normal = n.x * jacobian[0] + n.y * jacobian[1] + n.z * jacobian[2];
  }
  if (tile.plan.weights.vertices != nullptr) {
    const WeightedPoint point = WeightedOfPatch(tile.plan, tile.first + in_tile, b);
    position = point.Weigh(position);
    by_normal = n + point.weight * (by_normal - n);
  }
  Store(samples.positions + i, stride, position - samples.centres[in_tile]);
  if constexpr (kByNormal) Store(samples.by_normal + i, stride, by_normal);
}

template <typename T>
cudaError_t Launch(const Tile& tile, const Samples<T>& samples, cudaStream_t stream) {
  const size_t items = tile.count * static_cast<size_t>(samples.m);
  if (items == 0) return cudaSuccess;
  CentreKernel<<<Blocks(tile.count), kBlockThreads, 0, stream>>>(tile, samples.centres);
  if (const cudaError_t error = cudaPeekAtLastError(); error != cudaSuccess) return error;
  if (samples.by_normal != nullptr) {
    SampleKernel<T, true><<<Blocks(items), kBlockThreads, 0, stream>>>(tile, samples);
  } else {
    SampleKernel<T, false><<<Blocks(items), kBlockThreads, 0, stream>>>(tile, samples);
  }
  return cudaPeekAtLastError();
}

__global__ void __launch_bounds__(kBlockThreads)
    RoundKernel(const double* from, size_t count, float* to) {
  const size_t i = Item();
  if (i < count) to[i] = static_cast<float>(from[i]);
}

}  // namespace

cudaError_t LaunchSamples(const Tile& tile, const Samples<float>& samples, cudaStream_t stream) {
  return Launch(tile, samples, stream);
}

cudaError_t LaunchSamples(const Tile& tile, const Samples<double>& samples, cudaStream_t stream) {
  return Launch(tile, samples, stream);
}

cudaError_t LaunchRound(const double* from, size_t count, float* to, cudaStream_t stream) {
  if (count == 0) return cudaSuccess;
  RoundKernel<<<Blocks(count), kBlockThreads, 0, stream>>>(from, count, to);
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
