// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/support/stream_clients.h"

#include <utility>

namespace latticed::testing {

void EventLog::Take(const v1::SceneEvent& event) {
  events.push_back(event);
  switch (event.event_case()) {
    case v1::SceneEvent::kHello:
      hello = event.hello();
      break;
    case v1::SceneEvent::kLatticeState:
      std::erase_if(others, [&event](const auto& other) {
        const auto& left = event.lattice_state().indexes();
        return std::ranges::find(left, other.first) == left.end();
      });
      if (event.lattice_state().index() == 0) {
        lattice = event.lattice_state();
      } else {
        others[event.lattice_state().index()] = event.lattice_state();
        lattice.set_revision(event.lattice_state().revision());  // also where lattice 0 is gone
      }
      break;
    case v1::SceneEvent::kLatticeDelta: {
      const v1::LatticeDelta& delta = event.lattice_delta();
      const bool also = delta.revision() == lattice.revision() && delta.lattice() > last_moved_;
      EXPECT_TRUE(also || delta.revision() == lattice.revision() + 1) << "deltas have no gap";
      last_moved_ = delta.lattice();
      lattice.set_revision(delta.revision());
      v1::LatticeState& edited = delta.lattice() == 0 ? lattice : others.at(delta.lattice());
      if (delta.has_strength()) edited.set_strength(delta.strength());
      for (int i = 0; i < delta.indices_size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          edited.mutable_lattice()->set_control_points(3 * static_cast<int>(delta.indices(i)) + k,
                                                       delta.positions(3 * i + k));
        }
      }
      ++deltas;
      break;
    }
    case v1::SceneEvent::kTopology:
      topologies.push_back(event.topology());
      bounds.clear();
      break;
    case v1::SceneEvent::kQuantisation:
      quantisations.push_back(event.quantisation());
      break;
    case v1::SceneEvent::kUpdateBegin:
      EXPECT_EQ(in_update_, event.update_begin().restart());
      in_update_ = true;
      staged_.clear();
      staged_bounds_.clear();
      begins.push_back(event.update_begin());
      break;
    case v1::SceneEvent::kPatchLattice:
      EXPECT_TRUE(in_update_);
      EXPECT_LT(event.ByteSizeLong(), size_t{1} << 20);
      TakeSum(event.patch_lattice());
      break;
    case v1::SceneEvent::kChunks:
      EXPECT_TRUE(in_update_);
      EXPECT_LT(event.ByteSizeLong(), size_t{1} << 20);
      EXPECT_EQ(event.chunks().update_id(), begins.back().update_id());
      EXPECT_EQ(event.chunks().topology_id(), topologies.back().topology_id());
      if (begins.back().view().encoding() == v1::ENCODING_PATCHES) {
        EXPECT_EQ(event.chunks().quantisation_id(), 0u);
      } else {
        EXPECT_EQ(event.chunks().quantisation_id(), quantisations.back().quantisation_id());
      }
      for (const v1::Chunk& chunk : event.chunks().chunks()) {
        if (begins.back().view().encoding() == v1::ENCODING_PATCHES) {
          TakeBounds(chunk);
        } else {
          TakeChunk(chunk);
        }
      }
      break;
    case v1::SceneEvent::kPatterns:
      TakePatterns(event);
      break;
    case v1::SceneEvent::kUpdateEnd:
      EXPECT_TRUE(in_update_);
      in_update_ = false;
      EXPECT_EQ(event.update_end().revision(), begins.back().revision());
      EXPECT_EQ(staged_.size(), begins.back().chunk_count());
      for (auto& [index, chunk] : staged_) {
        chunks[index] = std::move(*chunk.mutable_data());
        levels[index] = std::move(*chunk.mutable_levels());
      }
      for (const v1::Chunk& chunk : staged_bounds_) {
        const size_t end = chunk.first_edge() + chunk.data().size();
        bounds.resize(std::max(bounds.size(), end));
        std::ranges::copy(chunk.data(), bounds.begin() + chunk.first_edge());
      }
      EXPECT_GE(event.update_end().revision(), ends.empty() ? 0 : ends.back().revision());
      ends.push_back(event.update_end());
      break;
    case v1::SceneEvent::kEditResult:
      results.push_back(event.edit_result());
      break;
    case v1::SceneEvent::kPresence:
      EXPECT_TRUE(lattice.has_lattice()) << "presence comes after lattice_state";
      presences.push_back(event.presence());
      break;
    case v1::SceneEvent::kHeartbeat:
      ++heartbeats;
      break;
    case v1::SceneEvent::kGoaway:
      goaways.push_back(event.goaway());
      break;
    default:
      ADD_FAILURE() << "unexpected " << event.ShortDebugString();
  }
}

void EventLog::TakeSum(const v1::PatchLattice& news) {
  if (news.has_state()) {
    sum = news.state();
  } else {
    const v1::LatticeDelta& delta = news.delta();
    EXPECT_EQ(delta.structure_id(), sum.structure_id());
    for (int i = 0; i < delta.indices_size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        sum.mutable_lattice()->set_control_points(3 * static_cast<int>(delta.indices(i)) + k,
                                                  delta.positions(3 * i + k));
      }
    }
    sum.set_revision(delta.revision());
  }
  EXPECT_EQ(sum.revision(), begins.back().revision());
}

void EventLog::TakePatterns(const v1::SceneEvent& event) {
  EXPECT_LT(event.ByteSizeLong(), size_t{1} << 20);
  EXPECT_GT(event.patterns().patterns_size(), 0);
  for (const v1::PatchPattern& pattern : event.patterns().patterns()) {
    EXPECT_TRUE(patterns.emplace(pattern.code(), pattern).second) << "each comes once";
  }
}

void EventLog::TakeChunk(const v1::Chunk& chunk) {
  EXPECT_LE(chunk.revision(), begins.back().revision());
  EXPECT_EQ(chunk.levels().empty(), begins.back().view().tolerance() == 0);
  EXPECT_EQ(chunk.chunk_count(), 0u);
  EXPECT_EQ(chunk.first_edge(), 0u);
  for (size_t i = 0; i + 1 < chunk.levels().size(); i += 2) {
    const uint32_t code = static_cast<uint8_t>(chunk.levels()[i]) |
                          static_cast<uint32_t>(static_cast<uint8_t>(chunk.levels()[i + 1])) << 8;
    EXPECT_TRUE(patterns.contains(code)) << "a pattern comes before its first use";
  }
  EXPECT_TRUE(staged_.emplace(chunk.index(), chunk).second);
}

void EventLog::TakeBounds(const v1::Chunk& chunk) {
  EXPECT_LE(chunk.revision(), begins.back().revision());
  EXPECT_TRUE(chunk.levels().empty());
  EXPECT_NE(chunk.chunk_count(), 1u) << "0 says the same";
  for (uint32_t i = 0; i < std::max(chunk.chunk_count(), 1u); ++i) {
    EXPECT_TRUE(staged_.try_emplace(chunk.index() + i).second);
  }
  staged_bounds_.push_back(chunk);
}

}  // namespace latticed::testing
