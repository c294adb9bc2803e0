// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What decides on a watcher's next event: without scene, backend, threads or clocks.
#ifndef LATTICED_TESTS_SERVER_ENGINE_WATCH_NEXT_EVENT_FIXTURE_H_
#define LATTICED_TESTS_SERVER_ENGINE_WATCH_NEXT_EVENT_FIXTURE_H_

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/engine/watch/next_event.h"

namespace latticed::testing {

inline const absl::Time kStart = absl::UnixEpoch() + absl::Hours(1);
inline constexpr size_t kChunkBytes = size_t{40} << 10;

// `revisions` holds, for each chunk, the revision at which it last changed.
inline std::shared_ptr<const Snapshot> MakeSnapshot(uint64_t revision,
                                                    std::vector<uint64_t> revisions,
                                                    uint64_t box = 1, uint64_t structure = 1) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = revision;
  snapshot->structure_id = structure;
  snapshot->box.id = box;
  snapshot->edit_time = kStart;
  snapshot->chunks = ChunkTable(revisions.size());
  for (size_t c = 0; c < revisions.size(); ++c) {
    snapshot->chunks.Set(c, {revisions[c], MakeSharedBytes(std::vector<uint8_t>(kChunkBytes)), {}});
  }
  return snapshot;
}

inline std::shared_ptr<const LatticeDelta> MakeDelta(uint64_t revision, uint64_t structure = 1) {
  auto delta = std::make_shared<LatticeDelta>();
  delta->revision = revision;
  delta->structure_id = structure;
  return delta;
}

// "lattice 3", "delta 4", "topology t", "quantisation 1", "begin 1@5 restart", "sum 5" or "sum 5 since 4" control points,
// "patterns 0 9", "batch 0 1", "end 1@5"; "-" for none.
inline std::string Text(const NextEvent& next) {
  if (!next.event.has_value()) return "-";
  struct {
    std::string operator()(const LatticeWhole& e) {
      return "lattice " + std::to_string(e.state->revision);
    }
    std::string operator()(const std::shared_ptr<const LatticeDelta>& e) {
      return "delta " + std::to_string(e->revision);
    }
    std::string operator()(const TopologyNews& e) { return "topology " + e.topology_id; }
    std::string operator()(const QuantisationNews& e) {
      return "quantisation " + std::to_string(e.snapshot->box.id);
    }
    std::string operator()(const PatternNews& e) {
      std::string text = "patterns";
      for (const uint16_t code : e.codes) text += " " + std::to_string(code);
      return text;
    }
    std::string operator()(const UpdateBegins& e) {
      return "begin " + std::to_string(e.update_id) + "@" + std::to_string(e.revision) +
             (e.restart ? " restart" : "");
    }
    std::string operator()(const SumNews& e) {
      const std::string text = "sum " + std::to_string(e.snapshot->summed_points->size());
      return e.before == nullptr ? text : text + " since " + std::to_string(e.before->size());
    }
    std::string operator()(const ChunkBatch& e) {
      std::string text = "batch";
      for (const uint32_t chunk : e.chunks) text += " " + std::to_string(chunk);
      return text;
    }
    std::string operator()(const UpdateEnds& e) {
      return "end " + std::to_string(e.update_id) + "@" + std::to_string(e.revision);
    }
  } text;
  return std::visit(text, *next.event);
}

class NextEventTest : public ::testing::Test {
 protected:
  NextEventTest() {
    head_->revision = 0;
    offer_.state = head_;
    offer_.topology_id = "t";
    offer_.now = kStart;
  }
  // Takes events until there is none, and returns them as texts.
  std::vector<std::string> Drain() {
    std::vector<std::string> texts;
    while (true) {
      const NextEvent next = Next(client_, offer_);
      if (!next.event.has_value()) return texts;
      // Like the scene, stop offering deltas that the client has.
      if (std::holds_alternative<LatticeWhole>(*next.event)) offer_.deltas = {};
      auto& deltas = offer_.deltas.deltas;
      if (!deltas.empty()) deltas.erase(deltas.begin());
      texts.push_back(Text(next));
    }
  }
  // Sends and acknowledges all of revision 0, two chunks.
  void HaveFirstUpdate() {
    offer_.snapshot = MakeSnapshot(0, {0, 0});
    Drain();
    Acknowledge(client_, client_.last_update_id);
  }
  void Edit(uint64_t revision, std::shared_ptr<const Snapshot> snapshot) {
    head_->revision = revision;
    client_.lattice_revision = revision;
    offer_.snapshot = std::move(snapshot);
  }

  const std::shared_ptr<SceneState> head_ = std::make_shared<SceneState>();
  ClientState client_;
  WatchOffer offer_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_ENGINE_WATCH_NEXT_EVENT_FIXTURE_H_
