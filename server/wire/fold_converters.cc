// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/fold_converters.h"

#include <array>
#include <utility>

#include "server/wire/converters.h"
#include "server/wire/enum_table.h"

namespace latticed {
namespace {

constexpr auto kFoldScopes = std::to_array<std::pair<v1::FoldScope, FoldScope>>(
    {{v1::FOLD_SCOPE_SURFACE, FoldScope::kSurface},
     {v1::FOLD_SCOPE_VOLUME, FoldScope::kVolume},
     {v1::FOLD_SCOPE_UNSPECIFIED, FoldScope::kSurface}});

constexpr auto kFoldStates = std::to_array<std::pair<v1::FoldState, FoldState>>(
    {{v1::FOLD_STATE_FOLDED, FoldState::kFolded},
     {v1::FOLD_STATE_UNDECIDED, FoldState::kUndecided}});

}  // namespace

absl::StatusOr<FoldScope> FoldScopeFromProto(v1::FoldScope scope) {
  return ReadEnum(kFoldScopes, scope, "scope");
}

v1::FoldReport ToProto(const FoldReport& report, uint64_t revision, uint64_t structure_id,
                       size_t most) {
  v1::FoldReport result;
  result.set_revision(revision);
  result.set_structure_id(structure_id);
  result.set_certified(report.certified());
  result.set_boxes(report.boxes);
  result.set_folded(report.Count(FoldState::kFolded));
  result.set_undecided(report.Count(FoldState::kUndecided));
  for (const FoldState state : {FoldState::kFolded, FoldState::kUndecided}) {
    for (const FoldedBox& box : report.places) {
      if (box.state != state || static_cast<size_t>(result.places_size()) == most) continue;
      v1::FoldedBox& place = *result.add_places();
      place.set_state(WriteEnum(kFoldStates, box.state));
      place.mutable_box()->set_u(box.place[0]);
      place.mutable_box()->set_v(box.place[1]);
      place.mutable_box()->set_w(box.place[2]);
      *place.mutable_rest_point() = ToProto(box.rest_point);
      place.set_determinant(box.determinant);
    }
  }
  return result;
}

}  // namespace latticed
