// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/history_checks.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "server/store/records/scene_codec.h"

namespace latticed::fuzz {
namespace {

// Ends the program with what does not hold.
void Require(const absl::Status& status, const char* what) {
  if (status.ok()) return;
  std::fprintf(stderr, "%s: %s\n", what, status.ToString().c_str());
  std::abort();
}
void Require(bool holds, const char* what) {
  Require(holds ? absl::OkStatus() : absl::InternalError("does not hold"), what);
}

std::string BytesOf(const EditHistory& history) {
  return EncodeImage({.histories = {history.image()}, .box = {}, .now = {}, .commit_time = {}});
}

void CheckImage(const EditHistory& history) {
  const std::string bytes = BytesOf(history);
  auto image = DecodeImage(bytes);
  Require(image.status(), "an image is decoded");
  const auto again = EditHistory::FromImage(std::move(image->histories[0]));
  Require(again.status(), "an image is a history");
  Require(SameBits(BytesOf(*again), bytes), "an image has the same bits again");
}

}  // namespace

bool SameBits(std::string a, std::string b) {
  if (a == b) return true;
  std::ranges::sort(a);
  std::ranges::sort(b);
  return a == b;
}

Lattice FirstLattice() {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 2, 3});
  return *FitLattice(bounds, {4, 4, 4}, {2, 2, 2}, 0.05);
}

void CheckHistory(EditHistory history) {
  Require(Validate(history.lattice()), "the lattice is valid");
  CheckImage(history);
  const std::vector<Edit> edits = {Undo{UndoScope::kScene},
                                   Undo{UndoScope::kScene},
                                   Redo{},
                                   SetControlPoints{{0, 1}, {{0.5, 0.25, 1}, {2, 3, 4}}},
                                   InsertKnot{1, 0.375},
                                   Undo{},
                                   Redo{},
                                   RemoveLattice{},
                                   Undo{},
                                   Redo{},
                                   Undo{},
                                   Undo{},
                                   Undo{}};
  auto now = EditHistory::TimePoint(std::chrono::hours(1));
  uint64_t sequence = history.last_sequence("fuzzer");
  for (const Edit& edit : edits) {
    now += std::chrono::seconds(1);
    EditBatch batch{
        .editor_id = "fuzzer", .sequence = ++sequence, .structure_id = history.structure_id()};
    batch.edits.push_back(edit);
    const auto admit = [](const LatticeStructure&) { return absl::OkStatus(); };
    history.Apply(batch, now, admit).status().IgnoreError();
    Require(Validate(history.lattice()), "the lattice is valid after an edit");
  }
  history.CommitIdleGestures(now + std::chrono::hours(1));
  CheckImage(history);
}

}  // namespace latticed::fuzz
