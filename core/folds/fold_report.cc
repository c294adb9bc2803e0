// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/fold_report.h"

#include <algorithm>

namespace latticed {

size_t FoldReport::Count(FoldState state) const {
  return static_cast<size_t>(std::ranges::count(places, state, &FoldedBox::state));
}

FoldState FoldReport::StateOf(uint32_t box) const {
  const auto found = std::ranges::lower_bound(places, box, {}, &FoldedBox::box);
  return found == places.end() || found->box != box ? FoldState::kCertified : found->state;
}

const FoldedBox* NewFold(const FoldReport& before, const FoldReport& after) {
  const auto worse = std::ranges::find_if(after.places, [&](const FoldedBox& place) {
    return place.state > before.StateOf(place.box);
  });
  return worse == after.places.end() ? nullptr : &*worse;
}

}  // namespace latticed
