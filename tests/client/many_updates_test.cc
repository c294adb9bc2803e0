// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A Surface that takes and decodes updates for hours. This program counts allocations.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "client/cpp/library/surface.h"
#include "core/codec/chunk_encoder.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

// Updates of a long drag. Each moves a control point and replaces all chunks of the layout and grid in force, which change now
// and then; before every tenth, an update begins and does not end.
class LongDrag {
 public:
  LongDrag() {
    const auto encoder = MakeChunkEncoder("latticed");
    for (unsigned seed = 1; seed <= 100; ++seed) {
      const auto chunk =
          latticed::testing::MakeChunk(kPoints, 12, 8, latticed::testing::Data::kWalk, seed);
      const auto stream =
          latticed::testing::EncodePoints(*encoder, chunk.vertices(), 4095 * 0.25).value();
      streams_.emplace_back(stream.begin(), stream.end());
      first_x_.push_back(0.25 * chunk.integers.positions[0]);
    }
    v1::SceneEvent state;
    for (int i = 0; i < 24; ++i)
      state.mutable_lattice_state()->mutable_lattice()->add_control_points(i);
    Apply(std::move(state));
  }

  void Run(int updates) {
    for (int i = 0; i < updates; ++i) Update(++number_);
  }

 private:
  static constexpr uint32_t kChunks = 10, kPoints = 3;  // a chunk has one patch of one segment

  static v1::SceneEvent TopologyEvent(const std::string& id) {
    v1::SceneEvent event;
    v1::Topology* topology = event.mutable_topology();
    topology->set_topology_id(id);
    topology->set_patch_count(kChunks);
    topology->set_point_count(kChunks * kPoints);
    topology->set_segments(1);
    topology->add_chunk_runs()->set_chunk_count(kChunks);
    topology->mutable_chunk_runs(0)->set_patches_per_chunk(1);
    for (const uint32_t i : {1u, 0u, 0u, 0u, 1u, 0u, 0u, 0u, 1u})
      topology->mutable_pattern()->add_points(i);
    for (const uint32_t i : {0u, 1u, 2u}) topology->mutable_pattern()->add_triangles(i);
    return event;
  }

  static v1::SceneEvent QuantisationEvent(uint64_t id) {
    v1::SceneEvent event;
    event.mutable_quantisation()->set_quantisation_id(id);
    event.mutable_quantisation()->set_step(0.25);
    event.mutable_quantisation()->set_bits(12);
    event.mutable_quantisation()->set_normal_bits(8);
    return event;
  }

  static v1::SceneEvent BeginEvent(uint64_t id, uint32_t chunks) {
    v1::SceneEvent event;
    event.mutable_update_begin()->set_update_id(id);
    event.mutable_update_begin()->set_chunk_count(chunks);
    event.mutable_update_begin()->mutable_view()->set_encoding(v1::ENCODING_DRACO_POINTS);
    event.mutable_update_begin()->mutable_view()->set_normals(v1::NORMAL_MODE_FACET);
    return event;
  }

  void Update(uint64_t number) {
    v1::SceneEvent delta;
    delta.mutable_lattice_delta()->set_revision(number);
    delta.mutable_lattice_delta()->add_indices(number % 8);
    for (int axis = 0; axis < 3; ++axis)
      delta.mutable_lattice_delta()->add_positions(static_cast<double>(number));
    Apply(std::move(delta));
    if (number % 100 == 1) Apply(TopologyEvent(fmt::format("t{}", number / 100)));
    if (number % 20 == 1) Apply(QuantisationEvent(number / 20 + 1));
    if (number % 10 == 0) {
      Apply(BeginEvent(2 * number, kChunks));
      Apply(ChunksEvent(2 * number, number));
    }
    Apply(BeginEvent(2 * number + 1, kChunks));
    Apply(ChunksEvent(2 * number + 1, number));
    v1::SceneEvent end;
    end.mutable_update_end()->set_update_id(2 * number + 1);
    end.mutable_update_end()->set_revision(number);
    Apply(std::move(end));

    const auto points = surface_.Decode();
    ASSERT_OK(points);
    ASSERT_EQ(points->positions.size(), kChunks * kPoints);
    ASSERT_EQ(points->positions[0].x, first_x_[number % streams_.size()]);
  }

  v1::SceneEvent ChunksEvent(uint64_t update, uint64_t number) const {
    v1::SceneEvent event;
    event.mutable_chunks()->set_update_id(update);
    event.mutable_chunks()->set_topology_id(fmt::format("t{}", (number - 1) / 100));
    event.mutable_chunks()->set_quantisation_id((number - 1) / 20 + 1);
    for (uint32_t index = 0; index < kChunks; ++index) {
      v1::Chunk* chunk = event.mutable_chunks()->add_chunks();
      chunk->set_index(index);
      chunk->set_data(streams_[(number + index) % streams_.size()]);
    }
    return event;
  }

  void Apply(v1::SceneEvent event) { ASSERT_OK(surface_.Apply(std::move(event))); }

  std::vector<std::string> streams_;
  std::vector<double> first_x_;  // of each stream
  Surface surface_;
  uint64_t number_ = 0;
};

TEST(ManyUpdatesTest, TenThousandLeaveTheMemoryOfASurfaceAsItIs) {
  LongDrag drag;
  size_t first = 0;  // what the surface holds, and what an update takes for a moment
  {
    const latticed::testing::PeakMemory memory;
    drag.Run(1000);
    first = memory.peak();
  }
  const latticed::testing::PeakMemory memory;

  drag.Run(10'000);

  EXPECT_LE(memory.peak(), first);
}

}  // namespace
}  // namespace latticed::client
