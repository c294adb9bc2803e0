// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of the fused pipeline, as the .cc files see them. They run in this order: box polynomials,
// then vertices of chunks in lane order, then, for chunks that are read, from lane order to wire order.
//
// Layout   lane order, q points a patch, lane = patch in its chunk of 32; the last chunk is padded
//   kFloat32          float [chunk][point][x y z nx ny nz, or x y z][lane]
//   kQuantised8       8 bytes [chunk][point][lane]: x | y << 16, z | s << 16 | t << 24; s and
//                     t mean nothing in a view without normals
//   kQuantised16      8 bytes [chunk][point][lane]: x | y << 16, z and 16 bits of no meaning;
//                     then, 4 bytes [chunk][point][lane], s | t << 16
//   so every store of a warp fills whole cache lines.
// Units    world units relative to plan.local_origin
// Errors   cudaError_t of the launch; those of kernel_call.h
// Threads  no call waits; all pointers must stay valid until the stream has run the kernels
#ifndef LATTICED_CUDA_FUSED_FUSED_KERNELS_H_
#define LATTICED_CUDA_FUSED_FUSED_KERNELS_H_

#include <cstddef>
#include <cstdint>

#include "cuda/device/kernel_call.h"
#include "cuda/plan/fused_tables.h"
#include "cuda/plan/plan_tables.h"

namespace latticed::kernels {

// The polynomial of each box in the units of the output format, float: [box][component][coefficient],
// rows of CoefficientStride; coefficient (a (d1 + 1) + b)(d2 + 1) + c belongs to l0^a l1^b l2^c.
//
//   scale R + offset     of the point; of a plan with weights, scale (R - x) of its displacement
struct BoxPolynomials {
  double scale;
  Vec3d offset;
  float* coefficients;
  float* rest;  // with weights: scale x + offset, [box][component][1, l0, l1, l2]; else null
  float* cofactor_bounds;  // upper bounds of ||cof J|| in the box, J of the scaled polynomial
  float* length_bounds;    // with weights: upper bounds of the displacement's length; else null
};
// Rows are padded to multiples of 16 bytes.
LATTICED_HD constexpr int CoefficientStride(int d0, int d1, int d2) {
  return ((d0 + 1) * (d1 + 1) * (d2 + 1) + 3) / 4 * 4;
}
// `count` boxes, each once; all boxes of the plan when `numbers` is null.
struct BoxList {
  const uint32_t* numbers;
  uint32_t count;
};
// Runs after the copy of the control points, which may bring the list too.
KernelCall BoxPolynomialsCall(const PlanTables& plan, const FusedTables& tables,
                              const Vec3d* control_points, const BoxList& boxes,
                              const BoxPolynomials& polynomials);

enum class LaneFormat { kFloat32, kQuantised8, kQuantised16 };

// Quantised formats: integer = round(top * saturate(p)), where p is 0 to 1 over the quantisation box.
struct FusedOutput {
  LaneFormat format;
  float top;        // 2^position_bits - 1
  int normal_bits;  // of the quantised formats
  uint8_t* vertices;
  uint8_t* second_plane;  // kQuantised16
};

// The most segments with which direct_kernel.cuh evaluates the points one by one; n is the sum of the
// degrees. The table is its time over that of the composing kernel, by segments, measured at 113,663
// patches:
//           facet normals                              vertex normals
//   1x1x1   0.78 to 0.86 up to 2, 0.96 and 1.05 at 3   0.65 to 0.92 up to 4, 0.97 and 1.03 at 5
//   2x2x2   0.63 to 0.96 up to 4, 1.09 and 1.15 at 5   0.50 to 0.89 up to 5, 0.96 and 1.03 at 6
//   3x3x3   0.35 to 0.87 up to 5, 0.85 and 1.06 at 6   0.19 to 0.46 up to 6
// Where there are two numbers, the first is of float32. Other degrees follow by analogy.
LATTICED_HD constexpr int MostDirectSegments(int n, Normals normals) {
  return 2 + n / 3 + (normals == Normals::kSmooth ? 1 : 0);
}

// Warps of a block. In the composing kernel they share a chunk, or a part of one; in the direct kernel each
// warp has its own.
inline constexpr int kFusedWarps = 3, kDirectWarps = 4;

// How chunks of a launch are divided among blocks (direct kernel: among warps). The first `whole` chunks
// take one block each, the others `parts` blocks each, which share the chunk's rows (direct kernel: its
// triples of points). Every part repeats the work before the rows: in the composing kernel that is half of
// a chunk's time.
struct FusedBlocks {
  uint32_t whole, parts;
  uint32_t at_once;  // how many the device holds at once

  LATTICED_HD uint32_t Count(uint32_t chunks) const { return whole + (chunks - whole) * parts; }
  // A chunk, as its place in the launch, and which of its parts.
  struct Part {
    uint32_t index, part, parts;
  };
  LATTICED_HD Part PartOf(uint32_t block) const {
    if (block < whole) return {block, 0, 1};
    const uint32_t rest = block - whole;
    return {whole + rest / parts, rest % parts, parts};
  }
};

struct FusedLaunch {
  PlanTables plan;
  FusedTables tables;
  BoxPolynomials polynomials;
  const Vec3d* control_points;
  const uint8_t* attached;  // per seam
  const uint32_t* chunks;   // null: 0 … chunk_count - 1
  uint32_t chunk_count;
  FusedBlocks blocks;
  uint32_t patch_count;  // of the plan
  int segments;
  Normals normals;
  FusedOutput output;
};
// Divides chunks where multiprocessors would otherwise be idle:
//   all chunks        when they are fewer than the device holds at once. Direct kernel: an edit of 128 chunks
//                     with 4 segments takes 0.0267 ms, not 0.0317. Parts for twice as many blocks as the
//                     device holds are no faster, and slower from 535 chunks on.
//   the last chunks   that do not fill the device once more; composing kernel and float32 only, whose rows
//                     take longer. It saves 2 % there, and would cost quantised vertices up to 3 %.
// `blocks_at_once`: blocks of FusedCall that the device holds at once.
FusedBlocks DivideChunks(const FusedLaunch& launch, int blocks_at_once);
// Runs after the polynomials of all boxes that own points of the chunks. There is at least one chunk. Returns
// a call of no kernel for degrees that no plan has.
KernelCall FusedCall(const FusedLaunch& launch);

// Chunks of a view from lane order to the bytes of core/view/vertex_layout.h.
struct WireChunk {
  uint64_t offset;  // in `out`
  uint32_t chunk;
};
struct WireOrder {
  LaneFormat format;
  const uint8_t* vertices;
  const uint8_t* second_plane;
  const WireChunk* chunks;  // null: they follow each other, from first_chunk on
  uint32_t first_chunk;
  uint64_t chunk_bytes;  // of a chunk in wire order, unless it is the last one
  uint32_t chunk_count;
  uint32_t patch_count;  // of the plan
  int points_per_patch;
  bool normals;
  uint8_t* out;
};
cudaError_t LaunchWireOrder(const WireOrder& order, cudaStream_t stream);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_KERNELS_H_
