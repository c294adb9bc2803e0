// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of point sets, as the .cc files see them, in double. The formulas: core/points/README.md.
//
//   DeformCall    a piece    values, and normals, of its points; or their velocities
//   OutsideCall   a point    what a point outside the frame has
//   SumCall       a piece    S_pqr += sum over its points of l^p m^q n^r g, and of the cotangents of normals
//   AddCall       a box      the sums of its pieces
//
// Sums     A piece is a block. It reads kTilePoints points at a time into shared memory; then each power and component has
//          a thread of its own, which adds the points in order. The pieces of a box are added in order too. So no sum
//          depends on the order of threads, and there are no atomics.
// Layout   "place": in the order of SortedPoints. Vectors of a direction as in core/points/point_derivatives.h: positions by
//          the number of the point, then normals. "slot": number among the boxes that have points, ascending.
// Errors   cudaError_t of the launch
// Threads  no call waits; all pointers must stay valid until the stream has run the kernels
#ifndef LATTICED_CUDA_POINTS_POINT_KERNELS_H_
#define LATTICED_CUDA_POINTS_POINT_KERNELS_H_

#include <cstddef>
#include <cstdint>

#include "core/base/vec.h"
#include "core/ffd/box/box_polynomial.h"
#include "core/points/local_map.h"
#include "cuda/device/kernel_call.h"

namespace latticed::kernels {

// Threads of a block: one for each number of BoxNumbers.
inline constexpr uint32_t kPointThreads = 192;
static_assert(sizeof(BoxNumbers) == kPointThreads * sizeof(double));
inline constexpr uint32_t kTilePoints = kPointThreads;
// Enough pieces of 10^6 points for 132 multiprocessors.
inline constexpr uint32_t kPiecePoints = 4 * kTilePoints;

// At most kPiecePoints points of one box.
struct PointPiece {
  size_t first;  // place
  uint32_t count;
  uint32_t slot;
};

struct PointTables {
  const double* world[3];   // by place
  const double* normal[3];  // by place; null where there are none
  const uint32_t* order;    // by place: the number of the point
  const PointPiece* pieces;
  const uint32_t* first_piece;  // by slot, and one past the last
  const LocalMap* maps;         // by slot
  size_t points, inside;        // those outside have the places from `inside` on
  uint32_t piece_count, slot_count;
  int degree[3];
};

struct PointDeform {
  PointTables tables;
  const BoxPolynomial*
      values;  // by slot: what positions are made of; control points or their velocities
  // By slot, for velocities with normals: the polynomial of the control points. Null otherwise.
  const BoxPolynomial* shape;
  bool with_normals;
  Vec3d* out;
};
KernelCall DeformCall(const PointDeform& deform);
// Those outside stay where they are; with `velocities` they are zero.
KernelCall OutsideCall(const PointDeform& deform, bool velocities);

struct PointSums {
  PointTables tables;
  const BoxPolynomial* shape;  // by slot: of the control points. Null without normals
  const Vec3d* cotangents;     // of one direction
  BoxNumbers* of_pieces;
  BoxNumbers* of_boxes;  // by slot
};
KernelCall SumCall(const PointSums& sums);
KernelCall AddCall(const PointSums& sums);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_POINTS_POINT_KERNELS_H_
