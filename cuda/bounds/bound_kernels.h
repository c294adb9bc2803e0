// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernel of views of edge bounds, as the .cc files see it. It runs after those of cuda/adaptive/adaptive_kernels.h
// up to EdgeMaximaCall:
//
//   EdgeBytesCall     a warp a chunk   the byte of each edge (core/patches/edge_bound.h); whether one differs from the last
//
// The bytes go to the host's pinned memory, but only those of chunks that changed. So an edit of one control point sends
// what it changed, and no copy of its own.
//
// Units    world
// Errors   those of kernel_call.h
// Threads  no call waits; all pointers must stay valid until the stream has run the kernel
#ifndef LATTICED_CUDA_BOUNDS_BOUND_KERNELS_H_
#define LATTICED_CUDA_BOUNDS_BOUND_KERNELS_H_

#include <cstdint>

#include "cuda/device/kernel_call.h"

namespace latticed::kernels {

// Chunks of a block, and of a word of EdgeBytesLaunch::host_changed.
inline constexpr uint32_t kEdgeByteChunks = 32;

struct EdgeBytesLaunch {
  const uint32_t* edge_maxima;  // by edge: AdaptiveState
  const uint32_t* first_edges;  // by chunk: FirstEdges of core/patches/edge_order.h
  uint32_t chunk_count;         // at least 1
  double unit;                  // CurvatureUnit
  uint8_t* bytes;               // by edge: those of the last evaluation, then those of this one
  uint8_t* host_bytes;          // by edge, of chunks that changed
  uint32_t* host_changed;       // a bit a chunk
};
KernelCall EdgeBytesCall(const EdgeBytesLaunch& launch);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_BOUNDS_BOUND_KERNELS_H_
