// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of one box, evaluated together: positions and normals by nested Horner schemes in float32. Multiplications and
// additions are rounded one by one, in the same order for one lane as for many: a point has the same bits wherever it
// is evaluated. Many lanes are vector code, compiled once per instruction set.
//
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_POINT_BLOCK_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_POINT_BLOCK_H_

#include <cstddef>

#include "client/cpp/library/patches/box_polynomials.h"

namespace latticed::client {

inline constexpr size_t kBlockPoints = 16;

// By component, then by point.
template <size_t kPoints>
struct PointBlock {
  alignas(64) float local[3][kPoints];
  alignas(64) float rest[3][kPoints];  // normals at rest, of any length
  alignas(64) float weight[kPoints];   // where the box has `rest`
  alignas(64) float slope[3][kPoints];
  alignas(64) float position[3][kPoints];
  alignas(64) float normal[3][kPoints];
};

// Positions from `local`; with_normals: also unit normals from `rest`. A normal is 0 where `rest` is.
void EvaluateBlock(const BoxPolynomial& box, bool with_normals, PointBlock<kBlockPoints>* block);
void EvaluateBlock(const BoxPolynomial& box, bool with_normals, PointBlock<1>* block);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_POINT_BLOCK_H_
