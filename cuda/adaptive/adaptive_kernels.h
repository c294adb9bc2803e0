// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of views with a tolerance, as the .cc files see them. The mathematics is in core/adaptive. They run in this
// order, after the box polynomials of cuda/fused/fused_kernels.h:
//
//   ReachCall         once a view      how far the patches of each box reach
//   SlackCall         a box            what rounding can take from its bounds
//   BoundsCall        a named patch    bounds of its second derivatives
//   EdgeMaximaCall    a patch          the largest bound along each edge, by atomics
//   TakeSharedCall    a shared edge    its bound, for slices on other devices
//   RaiseSharedCall   a shared edge    the largest bound in all slices
//   PatternsCall      a patch          levels, pattern, error, where its points begin in its chunk; the largest error
//   LaunchScan        a chunk          where its points begin in the view
//   PointsCall        a point          its vertex
//
// The scan, the maxima and all else depend on the control points and the tolerance alone, not on the order of threads.
//
// Layout   vertices in the wire layout of core/backend.h, chunk after chunk; a chunk begins at its first point times the
//          bytes of a point
// Units    those of the polynomials: world, or shares of the quantisation box
// Errors   cudaError_t of the launch; those of kernel_call.h
// Threads  no call waits; all pointers must stay valid until the stream has run the kernels
#ifndef LATTICED_CUDA_ADAPTIVE_ADAPTIVE_KERNELS_H_
#define LATTICED_CUDA_ADAPTIVE_ADAPTIVE_KERNELS_H_

#include <cstddef>
#include <cstdint>

#include "core/adaptive/patch_curvature.h"
#include "core/base/limits.h"
#include "cuda/adaptive/flat_patterns.h"
#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

inline constexpr uint32_t kChunkPatches = limits::kPatchesPerChunk;
// The sums of core/adaptive/curvature_slack.h for one box.
constexpr uint32_t SlackSums(bool weighted) { return weighted ? 9 : 6; }

struct AdaptiveTables {
  const uint32_t* edges;  // [patch][3]: Patch::edge of the plan
  const PatternHead* heads;
  const PatternPlace* places;
  const PatternTriangle* triangles;
};

// Floats that are never negative are kept as their bits where atomics raise them: these are in the same order, and those
// of a NaN come last.
struct AdaptiveState {
  uint32_t* reach;          // [box][3]: PatchReach, rounded up, as bits; zeros at first
  float* slack;             // [box][SlackSums]: CurvatureSlack
  float* edge_bounds;       // by patch, three: CurvatureBounds::edge
  float* mixed_bounds;      // likewise, CurvatureBounds::mixed; null where nothing reads them
  uint32_t* edge_maxima;    // by edge, as bits; zeros before EdgeMaximaCall
  uint32_t* largest_error;  // of all patches, as bits; zero before PatternsCall
  uint64_t*
      chunk_first;  // the first point of each chunk, and after the last the number of all points
  uint16_t* codes;  // PatternKey::Code by patch; 0 past the last one, up to a whole chunk
  uint16_t* first_points;  // by patch: its first point in its chunk
};

struct AdaptiveLaunch {
  // chunks, chunk_count: those to bound. Of output, no second plane. blocks and segments are not used.
  FusedLaunch fused;
  AdaptiveTables tables;
  AdaptiveState state;
  uint32_t plan_chunks;
  float tolerance;  // what is left for curvature
  // PointsCall writes nothing if there are more points; its grid covers so many.
  uint64_t most_points;
};

// Edges that slices on other devices have too, and their bounds. They are not negative.
struct SharedMaxima {
  const uint32_t* edges;
  uint32_t count;  // at least 1
  uint32_t* edge_maxima;
  float* bounds;
};
KernelCall TakeSharedCall(const SharedMaxima& shared);
KernelCall RaiseSharedCall(const SharedMaxima& shared);

KernelCall ReachCall(const AdaptiveLaunch& launch);
KernelCall SlackCall(const AdaptiveLaunch& launch);
// Returns a call of no kernel for degrees that no plan has, as PointsCall.
KernelCall BoundsCall(const AdaptiveLaunch& launch);
KernelCall EdgeMaximaCall(const AdaptiveLaunch& launch);
// Leaves the number of points of each chunk in chunk_first.
KernelCall PatternsCall(const AdaptiveLaunch& launch);
// Turns counts into sums. `scratch` has ScanBytes.
cudaError_t ScanBytes(uint32_t plan_chunks, size_t& bytes);
cudaError_t LaunchScan(const AdaptiveLaunch& launch, void* scratch, size_t bytes,
                       cudaStream_t stream);
KernelCall PointsCall(const AdaptiveLaunch& launch);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_ADAPTIVE_ADAPTIVE_KERNELS_H_
