// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of edges, as a client's surface takes them from Chunk messages.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "client/cpp/library/surface.h"
#include "core/base/status_macros.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;

// Two chunks of one patch each.
v1::SceneEvent TopologyEvent() {
  v1::SceneEvent event;
  v1::Topology* topology = event.mutable_topology();
  topology->set_topology_id("t1");
  topology->set_patch_count(2);
  v1::ChunkRun* run = topology->add_chunk_runs();
  run->set_chunk_count(2);
  run->set_patches_per_chunk(1);
  return event;
}

// An update of bounds of the two chunks: each item is a Chunk with its first edge and its data.
struct EdgeRun {
  uint32_t index, count, first_edge;
  std::string data;
};
absl::Status ApplyBounds(Surface& surface, uint64_t id, uint32_t chunks,
                         const std::vector<EdgeRun>& parts) {
  v1::SceneEvent begin;
  begin.mutable_update_begin()->set_update_id(id);
  begin.mutable_update_begin()->set_chunk_count(chunks);
  begin.mutable_update_begin()->mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  LATTICED_RETURN_IF_ERROR(surface.Apply(begin).status());
  v1::SceneEvent event;
  event.mutable_chunks()->set_update_id(id);
  event.mutable_chunks()->set_topology_id("t1");
  for (const EdgeRun& part : parts) {
    v1::Chunk& chunk = *event.mutable_chunks()->add_chunks();
    chunk.set_index(part.index);
    chunk.set_chunk_count(part.count);
    chunk.set_first_edge(part.first_edge);
    chunk.set_data(part.data);
  }
  LATTICED_RETURN_IF_ERROR(surface.Apply(event).status());
  v1::SceneEvent end;
  end.mutable_update_end()->set_update_id(id);
  return surface.Apply(end).status();
}

TEST(SurfaceOfPatches, KeepsBoundsByEdge) {
  Surface surface;
  ASSERT_OK(surface.Apply(TopologyEvent()).status());

  ASSERT_OK(ApplyBounds(surface, 1, 2, {{0, 2, 0, "abcde"}}));
  EXPECT_EQ(*surface.EdgeBounds(), (std::vector<uint8_t>{'a', 'b', 'c', 'd', 'e'}));
  ASSERT_OK(ApplyBounds(surface, 2, 1, {{1, 0, 3, "xy"}}));
  EXPECT_EQ(*surface.EdgeBounds(), (std::vector<uint8_t>{'a', 'b', 'c', 'x', 'y'}));
  EXPECT_EQ(surface.bytes(), 5u);
  ASSERT_OK(ApplyBounds(surface, 3, 0, {}));
  EXPECT_EQ(*surface.EdgeBounds(), (std::vector<uint8_t>{'a', 'b', 'c', 'x', 'y'}));
}

TEST(SurfaceOfPatches, RefusesBoundsThatContradictTheirUpdateOrThePatches) {
  for (const auto& [chunks, parts] : {std::pair<uint32_t, std::vector<EdgeRun>>{
                                          2, {{0, 3, 0, "abcde"}}},  // more chunks than announced
                                      {2, {{0, 0, 0, "abc"}}},       // fewer
                                      {2, {{1, 2, 0, "abcde"}}},     // a chunk that does not exist
                                      {2, {{0, 2, 2, "abcde"}}},     // two patches have 6 edges
                                      {2, {{0, 2, 4294967295, "a"}}}}) {
    Surface surface;
    ASSERT_OK(surface.Apply(TopologyEvent()).status());
    EXPECT_THAT(ApplyBounds(surface, 1, chunks, parts), StatusIs(absl::StatusCode::kDataLoss));
  }
}

}  // namespace
}  // namespace latticed::client
