// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/view_room.h"

#include "core/base/limits.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {

absl::Status ViewRoom::Make(const DeformTarget& target, const ViewKey& key) {
  const uint64_t points =
      target.plan().patches.size() * static_cast<uint64_t>(PointsPerPatch(key.spec.segments));
  const uint64_t vertices = points * BytesPerPoint(key.spec);
  // Draco's chunks are a quarter of its integers or less.
  const bool draco = key.encoding == Encoding::kDracoPoints || key.encoding == Encoding::kDracoMesh;
  const uint64_t chunks = draco ? vertices / 4 : vertices;
  const uint64_t bytes =
      (target.evaluates_on_device() ? 0 : vertices) + limits::kMaxSnapshotsPerView * chunks;
  if (reservation_.bytes() > 0) return reservation_.Resize("the view", bytes);
  auto reservation = Reserve(budget_, "the view", bytes);
  if (!reservation.ok()) return reservation.status();
  reservation_ = *std::move(reservation);
  return absl::OkStatus();
}

}  // namespace latticed
