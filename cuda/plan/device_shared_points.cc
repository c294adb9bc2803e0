// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/device_shared_points.h"

#include "cuda/plan/pack_shared_points.h"

namespace latticed {

void AddSharedPoints(const DeformPlan& plan, TableUpload& upload,
                     kernels::SharedPointTables& tables) {
  const PackedSharedPoints packed = PackSharedPoints(plan);
  tables.patch_count = plan.patches.size();
  tables.on_seams_count = packed.on_seams.size();
  tables.orphan_count = packed.orphans.size();
  upload.Add(packed.vertex_owners, tables.vertex_owners);
  upload.Add(packed.edge_begins, tables.edge_begins);
  upload.Add(packed.edge_owners, tables.edge_owners);
  upload.Add(packed.edge_uses, tables.edge_uses);
  upload.Add(packed.on_seams, tables.on_seams);
  upload.Add(packed.orphans, tables.orphans);
}

}  // namespace latticed
