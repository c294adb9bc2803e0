// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/outside_converters.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/wire/enum_table.h"

namespace latticed {
namespace {

constexpr auto kOutsideModes = std::to_array<std::pair<v1::OutsideMode, OutsideMode>>(
    {{v1::OUTSIDE_MODE_FIXED, OutsideMode::kFixed},
     {v1::OUTSIDE_MODE_FALLOFF, OutsideMode::kFalloff},
     {v1::OUTSIDE_MODE_LINEAR, OutsideMode::kLinear},
     {v1::OUTSIDE_MODE_UNSPECIFIED, OutsideMode::kFixed}});

// Whether a falloff is smooth.
constexpr auto kContinuities = std::to_array<std::pair<v1::OutsideContinuity, bool>>(
    {{v1::OUTSIDE_CONTINUITY_C1, true},
     {v1::OUTSIDE_CONTINUITY_C0, false},
     {v1::OUTSIDE_CONTINUITY_UNSPECIFIED, true}});

using Numbers = google::protobuf::RepeatedField<double>;

absl::StatusOr<std::array<double, 6>> SidesFromProto(const Numbers& numbers,
                                                     std::string_view field) {
  std::array<double, 6> sides{};
  if (numbers.size() == 1) {
    sides.fill(numbers[0]);
  } else if (numbers.size() == static_cast<int>(sides.size())) {
    std::copy(numbers.begin(), numbers.end(), sides.begin());
  } else if (!numbers.empty()) {
    return error::InvalidField(
        field, fmt::format("got {} numbers, one for each of six sides or one for all are needed",
                           numbers.size()));
  }
  return sides;
}

}  // namespace

absl::StatusOr<Outside> FromProto(const v1::LatticeOutside& outside, std::string_view field) {
  Outside result;
  LATTICED_ASSIGN_OR_RETURN(result.mode,
                            ReadEnum(kOutsideModes, outside.mode(), fmt::format("{}.mode", field)));
  const std::string of_continuity = fmt::format("{}.continuity", field);
  LATTICED_ASSIGN_OR_RETURN(result.smooth,
                            ReadEnum(kContinuities, outside.continuity(), of_continuity));
  const std::string of_widths = fmt::format("{}.widths", field);
  LATTICED_ASSIGN_OR_RETURN(result.widths, SidesFromProto(outside.widths(), of_widths));
  const std::string of_steps = fmt::format("{}.steps", field);
  LATTICED_ASSIGN_OR_RETURN(result.steps, SidesFromProto(outside.steps(), of_steps));
  if (result.mode == OutsideMode::kFalloff) {
    if (!outside.widths().empty()) return result;
    return error::InvalidField(of_widths, "must be set for a falloff");
  }
  if (result.mode == OutsideMode::kFixed && !outside.widths().empty()) {
    return error::InvalidField(of_widths, "must be empty where points outside stay");
  }
  if (!outside.steps().empty()) {
    return error::InvalidField(of_steps, "must be empty but for a falloff");
  }
  if (!result.smooth) return error::InvalidField(of_continuity, "must be unset but for a falloff");
  return result;
}

absl::Status CheckHasWidths(const v1::LatticeOutside& outside, std::string_view field) {
  const bool has_none = std::ranges::all_of(outside.widths(), [](double w) { return w == 0; });
  if (outside.mode() != v1::OUTSIDE_MODE_LINEAR || !has_none) return absl::OkStatus();
  return error::InvalidField(fmt::format("{}.widths", field),
                             "must be set for a linear one here, where no mesh says how far");
}

v1::LatticeOutside ToProto(const Outside& outside) {
  v1::LatticeOutside result;
  result.set_mode(WriteEnum(kOutsideModes, outside.mode));
  if (outside.mode == OutsideMode::kFixed) return result;
  result.mutable_widths()->Add(outside.widths.begin(), outside.widths.end());
  if (outside.mode == OutsideMode::kLinear) return result;
  result.set_continuity(WriteEnum(kContinuities, outside.smooth));
  result.mutable_steps()->Add(outside.steps.begin(), outside.steps.end());
  return result;
}

}  // namespace latticed
