// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the fused kernels read of a plan in addition to PlanTables.
#ifndef LATTICED_CUDA_PLAN_FUSED_TABLES_H_
#define LATTICED_CUDA_PLAN_FUSED_TABLES_H_

#include <cstdint>

#include "core/base/vec.h"
#include "cuda/plan/device_patch.h"
#include "cuda/plan/feature_uses.h"

namespace latticed::kernels {

// Box-local coordinates are (parameter - centre) * inverse_width; for the outside box, (world position -
// centre) * inverse_width.
struct FusedBox {
  Vec3d centre, inverse_width;  // by axis of the lattice, or of the world
  Vec3d gradient[3];            // of the coordinates by world position, by permuted axis
};

// Permuted axes: core/ffd/box/box_basis.h.
struct FusedTables {
  int axis[3];             // of the lattice, behind each permuted axis
  int degree[3];           // by permuted axis, none greater than the one before
  uint32_t box_stride[3];  // by axis of the lattice
  uint32_t box_count;      // with the outside box
  const FusedBox* boxes;
  const double* basis[3];  // by permuted axis: BoxBasis::Matrix, 16 doubles a knot span
  const SeamUse* seam_uses;
  uint32_t seam_use_count;
  const FeatureUses* feature_uses;  // one a patch
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_FUSED_TABLES_H_
