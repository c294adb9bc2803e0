// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/resident_view.h"

#include <numeric>

namespace latticed {

absl::Status ResidentView::EvaluateInParts(std::span<const Vec3d> control_points,
                                           const QuantisationBox& box,
                                           std::span<const uint32_t> chunks, Between between) {
  target_->Touch();
  std::vector<uint32_t> all;  // a view that failed wants all: core/backend.h
  bool again = false;
  return target_->residency().Run([&] {
    if (again && all.empty()) {
      all.resize(target_->plan().chunk_count());
      std::iota(all.begin(), all.end(), 0u);
    }
    const auto named = std::exchange(again, true) ? std::span<const uint32_t>(all) : chunks;
    return inner_->EvaluateInParts(control_points, box, named, between);
  });
}

}  // namespace latticed
