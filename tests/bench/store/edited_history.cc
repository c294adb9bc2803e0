// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/edited_history.h"

#include <chrono>
#include <cstdint>

#include "server/store/records/scene_codec.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

std::string EditedHistory::NextRecord() {
  SceneHistory& history = life_.history;
  life_.now += std::chrono::milliseconds(1);
  const uint64_t n = history.records() + 1;
  const double reach = n % 2 == 0 ? 0.01 : -0.01;
  MoveControlPoints move{.offset = {reach, 0, -reach}};
  for (uint64_t i = 0; i < kMoved; ++i) {
    const uint64_t point = (n / 2 * 31 + i * 17) % history.of(0).lattice().control_points.size();
    move.indices.push_back(static_cast<uint32_t>(point));
  }
  const EditBatch batch{.editor_id = "bench",
                        .sequence = n,
                        .structure_id = history.structure_id(),
                        .edits = {std::move(move)}};
  CheckOk(history.Apply(batch, life_.now, [](const auto&) { return absl::OkStatus(); }).status());
  return EncodeRecord(
      {.edit = history.LastRecord(batch, life_.now), .commit_time = life_.commit_time});
}

std::string EditedHistory::Snapshot() const {
  return EncodeImage({life_.history.images(), life_.box.value(), life_.now, life_.commit_time});
}

}  // namespace latticed::bench
