// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What pipelines that evaluate every patch by itself read of a plan besides device_plan.h: whose
// positions its corners and edges take. About 10 bytes a patch (pack_shared_points.h).
#ifndef LATTICED_CUDA_PLAN_DEVICE_SHARED_POINTS_H_
#define LATTICED_CUDA_PLAN_DEVICE_SHARED_POINTS_H_

#include "core/ffd/deform_plan.h"
#include "cuda/device/table_upload.h"
#include "cuda/plan/shared_point_tables.h"

namespace latticed {

// Fills `tables`; their pointers once `upload` is sent.
void AddSharedPoints(const DeformPlan& plan, TableUpload& upload,
                     kernels::SharedPointTables& tables);

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_DEVICE_SHARED_POINTS_H_
