// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Events of a surface of two chunks, one triangle each, and the chunks in all encodings.
#ifndef LATTICED_TESTS_CLIENT_SURFACE_EVENTS_H_
#define LATTICED_TESTS_CLIENT_SURFACE_EVENTS_H_

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>

#include "client/cpp/library/surface.h"
#include "core/codec/chunk_encoder.h"
#include "core/codec/octahedral.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/status_matchers.h"

namespace latticed::client::testing {

// Two chunks of one patch each. A patch has one segment: 3 points and 1 triangle.
inline v1::SceneEvent TopologyEvent(const std::string& id = "t1") {
  v1::SceneEvent event;
  v1::Topology* topology = event.mutable_topology();
  topology->set_topology_id(id);
  topology->set_patch_count(2);
  topology->set_point_count(6);
  topology->set_triangle_count(2);
  topology->set_segments(1);
  v1::ChunkRun* run = topology->add_chunk_runs();
  run->set_chunk_count(2);
  run->set_patches_per_chunk(1);
  for (const uint32_t i : {1u, 0u, 0u, 0u, 1u, 0u, 0u, 0u, 1u})
    topology->mutable_pattern()->add_points(i);
  for (const uint32_t i : {0u, 1u, 2u}) topology->mutable_pattern()->add_triangles(i);
  return event;
}

inline v1::SceneEvent QuantisationEvent() {
  v1::SceneEvent event;
  v1::Quantisation* quantisation = event.mutable_quantisation();
  quantisation->set_quantisation_id(1);
  quantisation->mutable_origin()->set_x(1000);
  quantisation->mutable_origin()->set_y(-8);
  quantisation->mutable_origin()->set_z(0.5);
  quantisation->set_step(0.25);
  quantisation->set_bits(12);
  quantisation->set_normal_bits(8);
  return event;
}

inline v1::SceneEvent BeginEvent(uint64_t id, uint32_t chunks, v1::Encoding encoding) {
  v1::SceneEvent event;
  event.mutable_update_begin()->set_update_id(id);
  event.mutable_update_begin()->set_chunk_count(chunks);
  event.mutable_update_begin()->mutable_view()->set_encoding(encoding);
  event.mutable_update_begin()->mutable_view()->set_normals(v1::NORMAL_MODE_FACET);
  return event;
}

inline v1::SceneEvent ChunkEvent(uint64_t update_id, uint32_t index, const std::string& data) {
  v1::SceneEvent event;
  event.mutable_chunks()->set_update_id(update_id);
  event.mutable_chunks()->set_topology_id("t1");
  event.mutable_chunks()->set_quantisation_id(1);
  v1::Chunk* chunk = event.mutable_chunks()->add_chunks();
  chunk->set_index(index);
  chunk->set_data(data);
  return event;
}

inline v1::SceneEvent EndEvent(uint64_t id, uint64_t revision) {
  v1::SceneEvent event;
  event.mutable_update_end()->set_update_id(id);
  event.mutable_update_end()->set_revision(revision);
  return event;
}

// Three points with x = first, first + 1, first + 2, y = 2 x, z = 3 x, all normals +z.
inline std::string RawChunk(float first) {
  std::string data;
  for (int i = 0; i < 3; ++i) {
    const float x = first + static_cast<float>(i);
    const float point[6] = {x, 2 * x, 3 * x, 0, 0, 1};
    data.append(reinterpret_cast<const char*>(point), sizeof(point));
  }
  return data;
}

inline std::string QuantisedChunk(uint16_t first) {
  std::string data;
  for (const int factor : {1, 2, 3}) {
    for (int i = 0; i < 3; ++i) {
      const auto value = static_cast<uint16_t>(factor * (first + i));
      data.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
  }
  const OctahedralNormal n = QuantiseNormal({0, 0, 1}, 8);
  data.append(3, static_cast<char>(n.s));
  data.append(3, static_cast<char>(n.t));
  return data;
}

inline std::string DracoChunk(uint16_t first, std::string_view writer = "reference") {
  const std::string data = QuantisedChunk(first);
  const auto vertices = QuantisedVertices::FromBytes(
      {reinterpret_cast<const uint8_t*>(data.data()), data.size()}, 3, 12, 8);
  const auto stream =
      latticed::testing::EncodePoints(*MakeChunkEncoder(writer), vertices, 4095 * 0.25);
  return {stream->begin(), stream->end()};
}

inline void ApplyOk(Surface& surface, v1::SceneEvent event) {
  ASSERT_OK(surface.Apply(std::move(event)));
}

inline void ApplyUpdate(Surface& surface, v1::Encoding encoding, const std::string& a,
                        const std::string& b) {
  ApplyOk(surface, TopologyEvent());
  ApplyOk(surface, QuantisationEvent());
  ApplyOk(surface, BeginEvent(1, 2, encoding));
  ApplyOk(surface, ChunkEvent(1, 1, b));
  ApplyOk(surface, ChunkEvent(1, 0, a));
  const auto update = surface.Apply(EndEvent(1, 7));
  ASSERT_OK(update);
  ASSERT_TRUE(update->has_value());
  EXPECT_EQ((*update)->chunk_count, 2u);
  EXPECT_EQ((*update)->bytes, a.size() + b.size());
}

}  // namespace latticed::client::testing

#endif  // LATTICED_TESTS_CLIENT_SURFACE_EVENTS_H_
