// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/patches/lattice_history.h"

#include <utility>

namespace latticed::client {
namespace {

absl::Status Check(const v1::LatticeDelta& delta, const v1::LatticeState& lattice) {
  if (delta.positions_size() != 3 * delta.indices_size()) {
    return absl::DataLossError("a lattice_delta must have three numbers per index");
  }
  for (const uint32_t index : delta.indices()) {
    if (3 * int64_t{index} + 3 > lattice.lattice().control_points_size()) {
      return absl::DataLossError("a lattice_delta names a control point that does not exist");
    }
  }
  return absl::OkStatus();
}

// A delta that Check has found right.
void Move(const v1::LatticeDelta& delta, v1::LatticeState* lattice) {
  auto* points = lattice->mutable_lattice()->mutable_control_points();
  for (int i = 0; i < delta.indices_size(); ++i) {
    const int first = 3 * static_cast<int>(delta.indices(i));
    for (int c = 0; c < 3; ++c) points->Set(first + c, delta.positions(3 * i + c));
  }
  if (delta.has_strength()) lattice->set_strength(delta.strength());
  lattice->set_revision(delta.revision());
}

template <typename News>
uint64_t RevisionOf(const News& news) {
  return std::visit([](const auto& of) { return of.revision(); }, news);
}

}  // namespace

void LatticeHistory::Take(v1::LatticeState state) {
  if (state.index() != (state.indexes().empty() ? 0 : state.indexes(0))) return;
  // Another run of a server may begin again at a lower revision.
  while (!news_.empty() && RevisionOf(news_.back()) >= state.revision()) news_.pop_back();
  newest_ = state;
  news_.emplace_back(std::move(state));
}

absl::Status LatticeHistory::Take(const v1::LatticeDelta& delta) {
  if (delta.structure_id() != newest_.structure_id()) return absl::OkStatus();  // a state follows
  if (delta.lattice() !=
      newest_.index()) {  // of another lattice: this one has a new revision, and moves nowhere
    v1::LatticeDelta elsewhere;
    elsewhere.set_revision(delta.revision());
    Move(elsewhere, &newest_);
    news_.emplace_back(std::move(elsewhere));
    return absl::OkStatus();
  }
  if (absl::Status s = Check(delta, newest_); !s.ok()) return s;
  Move(delta, &newest_);
  news_.emplace_back(delta);
  return absl::OkStatus();
}

void LatticeHistory::EndUpdate(uint64_t revision) {
  while (!news_.empty() && RevisionOf(news_.front()) <= revision) TakeOldest();
  const bool skipped = !of_update_.has_lattice() || of_update_.revision() != revision;
  if (skipped && !news_.empty()) TakeOldest();
}

void LatticeHistory::TakeOldest() {
  News& oldest = news_.front();
  if (auto* state = std::get_if<v1::LatticeState>(&oldest)) {
    of_update_.Swap(state);
  } else {
    Move(std::get<v1::LatticeDelta>(oldest), &of_update_);
  }
  news_.pop_front();
}

}  // namespace latticed::client
