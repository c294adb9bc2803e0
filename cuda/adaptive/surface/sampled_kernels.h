// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of the matrix pipelines under a tolerance, as the .cc files see them. They stand in the places of SlackCall and
// BoundsCall, and of PointsCall (cuda/adaptive/adaptive_kernels.h). All is in double, and in world units. Twin of
// core/cpu/adaptive/surface/sampled_surface.h.
//
//   SampledBoundsCall   a warp a named patch     samples, their control net, bounds of its second derivatives
//   SampledPointsCall   a thread a point         its vertex, by the definition
//
// Errors   those of kernel_call.h
// Threads  those of adaptive_kernels.h
#ifndef LATTICED_CUDA_ADAPTIVE_SURFACE_SAMPLED_KERNELS_H_
#define LATTICED_CUDA_ADAPTIVE_SURFACE_SAMPLED_KERNELS_H_

#include <vector_types.h>

#include "core/view/vertex_layout.h"
#include "cuda/adaptive/adaptive_kernels.h"
#include "cuda/plan/turned_tables.h"

namespace latticed::kernels {

// An edge of the plan, or a vertex: both ends are the same.
struct SharedPlace {
  uint32_t vertex[2];  // in canonical order
  uint32_t box;        // the owner
  uint32_t seam;       // or kNoSharedSeam
};
inline constexpr uint32_t kNoSharedSeam = ~uint32_t{0};

struct SampledTables {
  const SharedPlace* edges;     // of the plan
  const SharedPlace* vertices;  // of the plan
  const uchar4* samples;        // m
  const double* inverse;        // inv(B), m x m
  int degree;                   // of a patch
  int m;
  const TurnedTables* turned;
  double slack_of_net, mesh_reach;  // of core/adaptive/net_slack.h
};

struct SampledLaunch {
  AdaptiveLaunch adaptive;  // of `fused`, no tables, polynomials and output
  SampledTables tables;
  VertexWriter writer;
  size_t point_bytes;
  uint8_t* vertices;
};

KernelCall SampledBoundsCall(const SampledLaunch& launch);
KernelCall SampledPointsCall(const SampledLaunch& launch);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_ADAPTIVE_SURFACE_SAMPLED_KERNELS_H_
