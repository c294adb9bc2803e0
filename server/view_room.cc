// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/view_room.h"

#include "core/base/limits.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {

namespace {

bool IsDraco(const ViewKey& key) {
  return key.encoding == Encoding::kDracoPoints || key.encoding == Encoding::kDracoMesh;
}

uint64_t VertexBytes(const DeformPlan& plan, const ViewKey& key) {
  return plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(key.spec.segments)) *
         BytesPerPoint(key.spec);
}

}  // namespace

uint64_t MostChunkBytes(const DeformPlan& plan, const ViewKey& key) {
  // Draco's chunks are a quarter of its integers or less.
  return VertexBytes(plan, key) / (IsDraco(key) ? 4 : 1);
}

absl::Status ViewRoom::Make(const DeformTarget& target, const ViewKey& key) {
  const uint64_t bytes = (target.evaluates_on_device() ? 0 : VertexBytes(target.plan(), key)) +
                         limits::kMaxSnapshotsPerView * MostChunkBytes(target.plan(), key);
  if (budget_ != nullptr && IsDraco(key)) {
    if (auto s = budget_->KeepAtLeast("the view's encoder", target.EncoderBytes(key.spec));
        !s.ok()) {
      return s;
    }
  }
  if (reservation_.bytes() > 0) return reservation_.Resize("the view", bytes);
  auto reservation = Reserve(budget_, "the view", bytes);
  if (!reservation.ok()) return reservation.status();
  reservation_ = *std::move(reservation);
  return absl::OkStatus();
}

}  // namespace latticed
