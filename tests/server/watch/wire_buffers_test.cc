// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks as gRPC gets them: the bytes are protobuf's, and the payload is not copied from the snapshot.
#include "server/wire/wire_buffers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <grpcpp/support/proto_buffer_reader.h>

namespace latticed::testing {
namespace {

std::shared_ptr<const Snapshot> TwoChunks() {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->box.id = 3;
  snapshot->chunks = ChunkTable(2);
  snapshot->chunks.Set(0, {7, MakeSharedBytes(std::vector<uint8_t>(5'000, 'a')), {}});
  snapshot->chunks.Set(1, {9, MakeSharedBytes(std::vector<uint8_t>(300, 'b')), VertexDigest()});
  // The last chunk has two patches.
  const auto codes = std::make_shared<std::vector<uint16_t>>(limits::kPatchesPerChunk, 0x0008);
  codes->insert(codes->end(), {0x0102, 0x0009});
  snapshot->patterns = {codes, *codes};
  return snapshot;
}

std::vector<grpc::Slice> SlicesOf(const ChunkBatch& batch) {
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(EncodeChunks(batch).Dump(&slices).ok());
  return slices;
}

std::string BytesOf(const std::vector<grpc::Slice>& slices) {
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

TEST(WireBuffers, ALargePayloadIsNotCopied) {
  const ChunkBatch batch{.update_id = 5, .snapshot = TwoChunks(), .chunks = {0, 1}};

  const std::vector<grpc::Slice> slices = SlicesOf(batch);

  ASSERT_EQ(slices.size(), 3u) << "what is before the large chunk, its data, and all that follows";
  const auto data = batch.snapshot->chunks[0].data;
  EXPECT_EQ(slices[1].begin(), data.data());
  EXPECT_EQ(slices[1].size(), data.size());
}

TEST(WireBuffers, AMessageKeepsItsPayloadWhenTheSnapshotHasGone) {
  auto snapshot = TwoChunks();
  const std::weak_ptr<const void> payload = snapshot->chunks.Data(0).owner;
  std::vector<grpc::Slice> slices = SlicesOf({.snapshot = snapshot, .chunks = {0}});

  snapshot.reset();
  EXPECT_FALSE(payload.expired());
  slices.clear();

  EXPECT_TRUE(payload.expired());
}

TEST(WireBuffers, TheBytesAreProtobufs) {
  const ChunkBatch batch{
      .update_id = 5, .topology_id = "t", .snapshot = TwoChunks(), .chunks = {0, 1}};
  v1::SceneEvent expected;
  v1::Chunks& chunks = *expected.mutable_chunks();
  chunks.set_update_id(5);
  chunks.set_topology_id("t");
  chunks.set_quantisation_id(3);
  for (uint32_t i = 0; i < 2; ++i) {
    const SnapshotChunk chunk = batch.snapshot->chunks[i];
    v1::Chunk& added = *chunks.add_chunks();
    added.set_index(i);
    added.set_revision(chunk.revision);
    added.set_data(chunk.data.data(), chunk.data.size());
    if (i == 1) {
      added.set_levels(std::string("\x02\x01\x09\x00", 4));
    } else {
      for (size_t p = 0; p < limits::kPatchesPerChunk; ++p) {
        added.mutable_levels()->append("\x08\x00", 2);
      }
    }
  }
  EXPECT_TRUE(BytesOf(SlicesOf(batch)) == expected.SerializeAsString());
}

constexpr size_t kBlock = 5'000;

// Four chunks of bounds: 0 and 1 are neighbours in one buffer, 2 has another one, and 3 has no edges of its own.
std::shared_ptr<const Snapshot> FourChunksOfBounds() {
  const auto block = std::make_shared<std::vector<uint8_t>>(kBlock);
  std::iota(block->begin(), block->end(), uint8_t{1});
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->view = {{.format = VertexFormat::kEdgeBounds}, Encoding::kPatches};
  snapshot->first_edges =
      std::make_shared<const std::vector<uint32_t>>(std::vector<uint32_t>{0, 3, 5, 6, 6});
  snapshot->chunks = ChunkTable(4);
  snapshot->chunks.Set(0, {7, {block, block->data(), 3'000, kBlock}, {}});
  snapshot->chunks.Set(1, {9, {block, block->data() + 3'000, kBlock - 3'000, kBlock}, {}});
  snapshot->chunks.Set(2, {8, MakeSharedBytes({6}), {}});
  snapshot->chunks.Set(3, {8, MakeSharedBytes({}), {}});
  return snapshot;
}

TEST(WireBuffers, ConsecutiveChunksOfBoundsAreOneMessage) {
  const ChunkBatch batch{
      .update_id = 5, .topology_id = "t", .snapshot = FourChunksOfBounds(), .chunks = {0, 1, 2, 3}};

  const std::vector<grpc::Slice> slices = SlicesOf(batch);

  v1::SceneEvent expected;
  expected.mutable_chunks()->set_update_id(5);
  expected.mutable_chunks()->set_topology_id("t");
  v1::Chunk& chunk = *expected.mutable_chunks()->add_chunks();
  chunk.set_revision(9);
  const uint8_t* const shared = batch.snapshot->chunks[0].data.data();
  chunk.set_data(shared, kBlock);
  chunk.mutable_data()->push_back('\6');
  chunk.set_chunk_count(4);
  EXPECT_TRUE(BytesOf(slices) == expected.SerializeAsString());
  EXPECT_TRUE(std::ranges::any_of(slices, [shared](const grpc::Slice& slice) {
    return slice.begin() == shared && slice.size() == kBlock;
  })) << "what neighbours share is one slice";
}

TEST(WireBuffers, ChunksOfBoundsApartAreMessagesOfTheirOwn) {
  const ChunkBatch batch{
      .update_id = 5, .topology_id = "t", .snapshot = FourChunksOfBounds(), .chunks = {0, 2, 3}};

  v1::SceneEvent expected;
  expected.mutable_chunks()->set_update_id(5);
  expected.mutable_chunks()->set_topology_id("t");
  v1::Chunk& first = *expected.mutable_chunks()->add_chunks();
  first.set_revision(7);
  const auto data = batch.snapshot->chunks[0].data;
  first.set_data(data.data(), data.size());
  v1::Chunk& others = *expected.mutable_chunks()->add_chunks();
  others.set_index(2);
  others.set_revision(8);
  others.set_data("\6");
  others.set_chunk_count(2);
  others.set_first_edge(5);
  EXPECT_TRUE(BytesOf(SlicesOf(batch)) == expected.SerializeAsString());
}

TEST(WireBuffers, PatternsAreThoseOfTheirCodes) {
  v1::SceneEvent event;
  grpc::ByteBuffer bytes =
      EncodeEvent(WatchEvent(PatternNews{{0, 1 | 1 << 3 | 1 << 6, 1 | 1 << 9}}));
  grpc::ProtoBufferReader reader(&bytes);
  ASSERT_TRUE(event.ParseFromZeroCopyStream(&reader));

  ASSERT_EQ(event.patterns().patterns_size(), 3);
  const v1::PatchPattern& flat = event.patterns().patterns(0);
  EXPECT_EQ(flat.code(), 0u);
  EXPECT_EQ(flat.denominator(), 1u);
  EXPECT_THAT(flat.points(), ::testing::ElementsAre(1, 0, 0, 0, 1, 0, 0, 0, 1));
  EXPECT_THAT(flat.triangles(), ::testing::ElementsAre(0, 1, 2));
  const v1::PatchPattern& halves = event.patterns().patterns(1);
  EXPECT_EQ(halves.denominator(), 2u);
  EXPECT_EQ(halves.points_size(), 3 * 6);
  EXPECT_EQ(halves.triangles_size(), 3 * 4);
  const v1::PatchPattern& one_edge = event.patterns().patterns(2);
  EXPECT_THAT(one_edge.points(), ::testing::ElementsAre(2, 0, 0, 1, 1, 0, 0, 2, 0, 0, 0, 2));
  EXPECT_EQ(one_edge.triangles_size(), 3 * 2);
}

// The largest event of patterns stays below the bytes that a stream reserves for it, which are 192 KiB.
TEST(WireBuffers, PatternsFitAMessage) {
  size_t largest = 0;
  for (uint16_t first = 0; first < 1 << kPatternCodeBits; ++first) {
    if (!PatternKey::FromCode(first).has_value()) continue;
    largest = std::max(largest, EncodeEvent(WatchEvent(PatternNews{{first}})).Length());
  }
  EXPECT_LT(PatternNews::kMost * largest, size_t{192} << 10);
}

}  // namespace
}  // namespace latticed::testing
