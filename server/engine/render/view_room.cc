// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/view_room.h"

#include <algorithm>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {

namespace {

uint64_t UsualChunkBytes(const DeformPlan& plan, const ViewKey& key) {
  return VertexBytes(plan, key) / (IsDraco(key.encoding) ? kIntegersPerDraco : 1);
}

}  // namespace

uint64_t VertexBytes(const DeformPlan& plan, const ViewKey& key) {
  return plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(key.spec.segments)) *
         BytesPerPoint(key.spec);
}

absl::Status ViewRoom::Make(const DeformTarget& target, const ViewKey& key, const Kept& kept) {
  const uint64_t chunks = limits::kMaxSnapshotsPerView * UsualChunkBytes(target.plan(), key);
  const uint64_t vertices = target.evaluates_on_device() ? 0 : VertexBytes(target.plan(), key);
  const uint64_t bytes = std::max(vertices, kept.slots) + std::max(chunks, kept.chunks);
  if (budget_ != nullptr && IsDraco(key.encoding)) {
    LATTICED_RETURN_IF_ERROR(
        budget_->KeepAtLeast("the view's encoder", target.EncoderBytes(key.spec)));
  }
  if (reservation_.bytes() > 0) return reservation_.Resize("the view", bytes);
  LATTICED_ASSIGN_OR_RETURN(reservation_, Reserve(budget_, "the view", bytes));
  return absl::OkStatus();
}

}  // namespace latticed
