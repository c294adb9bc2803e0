// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of the matrix pipelines, as the .cc files see them. Each function enqueues one or
// more kernels.                                                     Cui & Feng 2014, §3.4 and §3.6
//
// Layout   matrices are column-major; a tile of t patches has 3t columns: x of all its patches,
//          then y, then z
// Units    world units relative to plan.local_origin
// Errors   cudaError_t of the launch; errors in a kernel show at the stream's next wait
// Threads  calls enqueue and do not wait; all pointers must stay until the stream has passed them
#ifndef LATTICED_CUDA_GEMM_GEMM_KERNELS_H_
#define LATTICED_CUDA_GEMM_GEMM_KERNELS_H_

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

#include "core/view/vertex_layout.h"
#include "cuda/plan/plan_tables.h"
#include "cuda/plan/shared_point_tables.h"
#include "cuda/plan/turned_tables.h"

namespace latticed::kernels {

// Patches first … first + count - 1, under one set of control points.
struct Tile {
  PlanTables plan;
  TurnedTables turned;
  const Vec3d* control_points;
  size_t first;
  size_t count;
};

// §3.4, one thread a sample: Rs[i] = R(u_i) - centre, and Rf[i] = dR/df(u_i), f the facet normal. With weights, of the
// weighted deformation (core/cpu/gemm/patch_sampler.h).
// `points`: the m index triples of bernstein.h. The centre is the mean of the three corners.
template <typename T>
struct Samples {
  const uchar4* points;
  int degree;  // n, of the deformed surface
  int m;
  T* positions;  // m x 3t
  T* by_normal;  // m x 3t, or null
  Vec3d* centres;
};
cudaError_t LaunchSamples(const Tile& tile, const Samples<float>& samples, cudaStream_t stream);
cudaError_t LaunchSamples(const Tile& tile, const Samples<double>& samples, cudaStream_t stream);

// Rounds each number to float.
cudaError_t LaunchRound(const double* from, size_t count, float* to, cudaStream_t stream);

// §3.6, one thread a tessellation point: writes vertices from [P; Pu; Pv], with their normals.
struct Surface {
  const float* products;  // [P; Pu; Pv], rows x 3t
  const float* across;    // Pf, q x 3t, smooth normals only
  size_t rows;
  const Vec3d* centres;
  const uchar4* pattern;  // barycentrics times segments of the q points
  int segments;
  int q;
  Normals normals;
  uint32_t* ill;  // IllWords(q t) words, one bit per point; only with normals
  VertexLayout layout;
  VertexWriter writer;
  uint8_t* vertices;
};
// The number of 32-bit words with one mark for each point.
LATTICED_HD constexpr size_t IllWords(size_t points) { return (points + 31) / 32; }
cudaError_t LaunchSurface(const Tile& tile, const Surface& surface, cudaStream_t stream);

// Copies shared positions from their owners, one thread a point.     core/ffd/plan/shared_points.h
struct SharedPositions {
  SharedPointTables tables;
  TurnedTables turned;
  const uint8_t* attached;  // per seam
  int segments;
  VertexLayout layout;
  VertexWriter writer;
  uint8_t* vertices;
};
cudaError_t LaunchSharedPoints(const PlanTables& plan, const Vec3d* control_points,
                               const SharedPositions& shared, cudaStream_t stream);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_GEMM_GEMM_KERNELS_H_
