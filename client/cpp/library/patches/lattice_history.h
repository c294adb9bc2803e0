// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattice of a stream at its newest revision, and at that of its last update, which may be older: edits are
// reported before the update that shows them. Of a scene of several lattices, the first one, or their sum.
//
// Memory   two lattices, and what came since the last update
// Errors   kDataLoss for a delta that contradicts the lattice
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_LATTICE_HISTORY_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_LATTICE_HISTORY_H_

#include <cstdint>
#include <deque>
#include <variant>

#include "absl/status/status.h"
#include "latticed/v1/event.pb.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

class LatticeHistory {
 public:
  void Take(v1::LatticeState state);
  [[nodiscard]] absl::Status Take(const v1::LatticeDelta& delta);
  // An update has ended at this revision, and all later ones end at it or above. Where a lattice_state has skipped the
  // revision, which it does in no view with ENCODING_PATCHES, of_update becomes that lattice_state.
  void EndUpdate(uint64_t revision);

  const v1::LatticeState& newest() const { return newest_; }
  const v1::LatticeState& of_update() const { return of_update_; }

 private:
  using News = std::variant<v1::LatticeState, v1::LatticeDelta>;

  void TakeOldest();

  v1::LatticeState newest_, of_update_;
  std::deque<News> news_;  // since of_update_, ascending
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_LATTICE_HISTORY_H_
