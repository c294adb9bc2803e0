// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes the surface watertight: copies shared positions from their owners, bit for bit.
//
// CopyKernel has one block per run of patches and one thread per point: first the corners, then the
// inner points of the edges that are copied. The few records of seams and orphans are not sorted. With
// n = max(1, segments - 1), item i is point i mod n of record i / n; a corner needs only its item 0.
// No point is both read and written (core/ffd/plan/shared_points.h), so the order does not matter.
#include "core/ffd/tessellation_pattern.h"
#include "cuda/device/launch.cuh"
#include "cuda/gemm/gemm_kernels.h"
#include "cuda/plan/plan_point.cuh"

namespace latticed::kernels {
namespace {

constexpr int kFirstEdge = 3;  // slot of edge 0
constexpr uint32_t kNoSeam = ~uint32_t{0};

__device__ size_t PatchOf(PackedUse use) { return use >> 4; }
__device__ int SlotOf(PackedUse use) { return static_cast<int>(use >> 1 & 7); }
__device__ bool IsReversed(PackedUse use) { return (use & 1) != 0; }

__host__ __device__ size_t PointsPerRecord(int segments) {
  return segments > 1 ? static_cast<size_t>(segments) - 1 : 1;
}

// Whether a record has a point k. Corners have one; edges have segments - 1.
__device__ bool IsThere(int slot, int k, int segments) {
  return slot < kFirstEdge ? k == 0 : k + 1 < segments;
}

// The index in the patch of inner point k of a slot, from the end of the edge if `reversed`.
__device__ size_t PointOf(int slot, int k, bool reversed, int segments) {
  if (slot < kFirstEdge) return static_cast<size_t>(EdgePoint(segments, slot, 0));
  const int at = reversed ? segments - 1 - k : k + 1;
  return static_cast<size_t>(EdgePoint(segments, slot - kFirstEdge, at));
}

__device__ void Copy(const SharedPositions& shared, DeviceCopy copy, int k) {
  if (!IsThere(SlotOf(copy.to), k, shared.segments)) return;
  shared.layout.CopyPosition(shared.layout.Place(shared.vertices, PatchOf(copy.from)),
                             PointOf(SlotOf(copy.from), k, IsReversed(copy.from), shared.segments),
                             shared.layout.Place(shared.vertices, PatchOf(copy.to)),
                             PointOf(SlotOf(copy.to), k, false, shared.segments));
}

__device__ void CopyCorner(const PlanTables& plan, const SharedPositions& shared, uint32_t patch,
                           int corner) {
  if (patch >= shared.tables.patch_count) return;
  const PackedUse to = PackUse(patch, static_cast<uint32_t>(corner), false);
  const PackedUse from = shared.tables.vertex_owners[plan.patches[patch].Vertex(corner)];
  if (from != kNoUse && from != to) Copy(shared, {from, to}, 0);
}

__global__ void __launch_bounds__(kBlockThreads)
    CopyKernel(const __grid_constant__ PlanTables plan,
               const __grid_constant__ SharedPositions shared) {
  const SharedPointTables& tables = shared.tables;
  const uint32_t first = blockIdx.x * kSharedRun;
  if (threadIdx.x < 3 * kSharedRun) {
    CopyCorner(plan, shared, first + threadIdx.x / 3, static_cast<int>(threadIdx.x % 3));
  }
  const uint32_t begin = tables.edge_begins[blockIdx.x], end = tables.edge_begins[blockIdx.x + 1];
  const auto points = static_cast<uint32_t>(PointsPerRecord(shared.segments));
  for (uint32_t item = threadIdx.x; item < (end - begin) * points; item += kBlockThreads) {
    const uint32_t i = begin + item / points, use = tables.edge_uses[i];
    const PackedUse to = PackUse(first + use % kSharedRun, kFirstEdge + use / kSharedRun, false);
    Copy(shared, {tables.edge_owners[i], to}, static_cast<int>(item % points));
  }
}

__global__ void __launch_bounds__(kBlockThreads)
    SeamCopyKernel(const __grid_constant__ SharedPositions shared) {
  const size_t points = PointsPerRecord(shared.segments), record = Item() / points;
  if (record >= shared.tables.on_seams_count) return;
  const DeviceSeamCopy seam_copy = shared.tables.on_seams[record];
  const bool attached = shared.attached[seam_copy.seam >> 1] != 0;
  if (attached != ((seam_copy.seam & 1) != 0)) return;
  Copy(shared, seam_copy.copy, static_cast<int>(Item() % points));
}

__global__ void __launch_bounds__(kBlockThreads)
    OrphanKernel(const __grid_constant__ PlanTables plan, const Vec3d* control_points,
                 const __grid_constant__ SharedPositions shared) {
  const size_t points = PointsPerRecord(shared.segments), record = Item() / points;
  if (record >= shared.tables.orphan_count) return;
  const DeviceOrphan orphan = shared.tables.orphans[record];
  if (orphan.seam != kNoSeam && shared.attached[orphan.seam] != 0) return;
  const int slot = SlotOf(orphan.use), k = static_cast<int>(Item() % points);
  if (!IsThere(slot, k, shared.segments)) return;
  const uint32_t a = orphan.vertex[0], b = orphan.vertex[1];  // equal for a corner
  const double t =
      slot < kFirstEdge ? 0 : static_cast<double>(k + 1) / static_cast<double>(shared.segments);
  shared.writer.WritePosition(
      shared.layout.Place(shared.vertices, PatchOf(orphan.use)),
      PointOf(slot, k, IsReversed(orphan.use), shared.segments),
      PlanPointOnEdge(plan, shared.turned, control_points, orphan.box, a, b, t));
}

}  // namespace

cudaError_t LaunchSharedPoints(const PlanTables& plan, const Vec3d* control_points,
                               const SharedPositions& shared, cudaStream_t stream) {
  const size_t points = PointsPerRecord(shared.segments);
  const SharedPointTables& tables = shared.tables;
  static_assert(kBlockThreads >= 3 * kSharedRun);
  const auto runs = static_cast<unsigned>((tables.patch_count + kSharedRun - 1) / kSharedRun);
  if (runs > 0) CopyKernel<<<runs, kBlockThreads, 0, stream>>>(plan, shared);
  if (tables.on_seams_count > 0) {
    SeamCopyKernel<<<Blocks(tables.on_seams_count * points), kBlockThreads, 0, stream>>>(shared);
  }
  if (tables.orphan_count > 0) {
    OrphanKernel<<<Blocks(tables.orphan_count * points), kBlockThreads, 0, stream>>>(
        plan, control_points, shared);
  }
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
