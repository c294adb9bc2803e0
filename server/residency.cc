// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/residency.h"

#include <utility>

#include "server/resident_target.h"

namespace latticed {

absl::StatusOr<std::shared_ptr<ResidentTarget>> Residency::Prepare(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline) {
  auto made = Run([&] { return backend_->Prepare(plan, pipeline); });
  if (!made.ok()) return made.status();
  return std::make_shared<ResidentTarget>(this, std::move(plan), *std::move(made));
}

}  // namespace latticed
