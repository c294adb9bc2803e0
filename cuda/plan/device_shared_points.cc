// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/device_shared_points.h"

#include "cuda/plan/pack_shared_points.h"
#include "cuda/plan/upload_table.h"

namespace latticed {

absl::StatusOr<DeviceSharedPoints> DeviceSharedPoints::Create(const DeformPlan& plan,
                                                              CudaContext& context) {
  const PackedSharedPoints packed = PackSharedPoints(plan);
  DeviceSharedPoints result;
  absl::Status status = UploadTable(context, packed.vertex_owners, result.vertex_owners_);
  if (status.ok()) status = UploadTable(context, packed.edge_begins, result.edge_begins_);
  if (status.ok()) status = UploadTable(context, packed.edge_owners, result.edge_owners_);
  if (status.ok()) status = UploadTable(context, packed.edge_uses, result.edge_uses_);
  if (status.ok()) status = UploadTable(context, packed.on_seams, result.on_seams_);
  if (status.ok()) status = UploadTable(context, packed.orphans, result.orphans_);
  if (!status.ok()) return status;
  result.tables_ = {.patch_count = plan.patches.size(),
                    .vertex_owners = result.vertex_owners_.data(),
                    .edge_begins = result.edge_begins_.data(),
                    .edge_owners = result.edge_owners_.data(),
                    .edge_uses = result.edge_uses_.data(),
                    .on_seams = result.on_seams_.data(),
                    .on_seams_count = result.on_seams_.size(),
                    .orphans = result.orphans_.data(),
                    .orphan_count = result.orphans_.size()};
  return result;
}

}  // namespace latticed
