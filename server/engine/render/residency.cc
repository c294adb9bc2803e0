// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/residency.h"

#include <algorithm>

#include "absl/strings/numbers.h"
#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/engine/render/resident_target.h"

namespace latticed {
namespace {

// A stream that has just ended has its scene for a moment longer; its client may be back by then. And
// what is deleted or retired meanwhile gives its memory to nobody in particular.
constexpr absl::Duration kLettingGo = absl::Milliseconds(50);
constexpr absl::Duration kPoll = absl::Milliseconds(5);

}  // namespace

absl::StatusOr<std::shared_ptr<ResidentTarget>> Residency::Prepare(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline) {
  LATTICED_ASSIGN_OR_RETURN(auto made, PrepareInner(plan, pipeline));
  return std::make_shared<ResidentTarget>(this, std::move(plan), std::move(made));
}

bool Residency::MayFitNow(const absl::Status& refusal, std::optional<absl::Time>& give_up) {
  if (!absl::IsResourceExhausted(refusal) || make_room_ == nullptr) return false;
  const error::Details details = error::DetailsOf(refusal);
  if (details.reason != "OUT_OF_MEMORY") return false;
  Lack lack{.bytes = details.asked_bytes - std::min(details.asked_bytes, details.free_bytes),
            .device = std::nullopt};
  const auto device = details.metadata.find(error::kDeviceKey);
  int number = 0;
  if (device != details.metadata.end() && absl::SimpleAtoi(device->second, &number)) {
    lack.device = number;
  }
  if (make_room_(lack)) {
    give_up.reset();
    return true;
  }
  const absl::Time now = absl::Now();
  if (!give_up.has_value()) give_up = now + kLettingGo;
  if (now > *give_up) return false;
  absl::SleepFor(kPoll);
  return true;
}

}  // namespace latticed
