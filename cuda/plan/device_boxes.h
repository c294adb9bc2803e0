// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the fused kernels read of a plan besides device_plan.h: its knot boxes, and who shares points
// in a chunk.
//
//   a patch      8 bytes: feature_uses.h
//   a box        120 bytes
//   a knot span  128 bytes: the matrix of core/ffd/box_basis.h
//   a corner or edge on a seam  8 bytes
#ifndef LATTICED_CUDA_PLAN_DEVICE_BOXES_H_
#define LATTICED_CUDA_PLAN_DEVICE_BOXES_H_

#include <memory>
#include <vector>

#include "core/ffd/deform_plan.h"
#include "cuda/device/table_upload.h"
#include "cuda/plan/fused_tables.h"

namespace latticed {

// Fills `tables`; their pointers once `upload` is sent.
void AddBoxes(const std::shared_ptr<const DeformPlan>& plan,
              const std::vector<kernels::SeamUse>& seam_uses, TableUpload& upload,
              kernels::FusedTables& tables);

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_DEVICE_BOXES_H_
