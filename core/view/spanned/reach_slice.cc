// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/reach_slice.h"

#include <algorithm>

#include "core/base/status_macros.h"

namespace latticed {

absl::Status ShareReach(std::span<ReachSlice* const> slices) {
  std::vector<Vec3d> largest;
  for (ReachSlice* const slice : slices) {
    LATTICED_ASSIGN_OR_RETURN(const std::vector<Vec3d> reach, slice->BoxReach());
    largest.resize(reach.size());
    for (size_t box = 0; box < reach.size(); ++box) {
      for (int a = 0; a < 3; ++a) largest[box][a] = std::max(largest[box][a], reach[box][a]);
    }
  }
  for (ReachSlice* const slice : slices) LATTICED_RETURN_IF_ERROR(slice->SetReach(largest));
  return absl::OkStatus();
}

}  // namespace latticed
