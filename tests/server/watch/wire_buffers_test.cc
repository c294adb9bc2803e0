// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks as gRPC gets them: the bytes are protobuf's, and the payload is not copied from the snapshot.
#include "server/wire/wire_buffers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace latticed::testing {
namespace {

std::shared_ptr<const Snapshot> TwoChunks() {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->box.id = 3;
  snapshot->chunks = ChunkTable(2);
  snapshot->chunks.Set(0, {7, MakeSharedBytes(std::vector<uint8_t>(5'000, 'a')), {}});
  snapshot->chunks.Set(1, {9, MakeSharedBytes(std::vector<uint8_t>(300, 'b')), {}});
  return snapshot;
}

std::vector<grpc::Slice> SlicesOf(const ChunkBatch& batch) {
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(EncodeChunks(batch).Dump(&slices).ok());
  return slices;
}

TEST(WireBuffers, APayloadIsNotCopied) {
  const ChunkBatch batch{.update_id = 5, .snapshot = TwoChunks(), .chunks = {0, 1}};

  const std::vector<grpc::Slice> slices = SlicesOf(batch);

  for (const uint32_t index : batch.chunks) {
    const SnapshotChunk& chunk = batch.snapshot->chunks[index];
    EXPECT_EQ(std::ranges::count_if(slices,
                                    [&chunk](const grpc::Slice& slice) {
                                      return slice.begin() == chunk.data.data &&
                                             slice.size() == chunk.data.size;
                                    }),
              1);
  }
}

TEST(WireBuffers, AMessageKeepsItsPayloadWhenTheSnapshotHasGone) {
  auto snapshot = TwoChunks();
  const std::weak_ptr<const void> payload = snapshot->chunks[0].data.owner;
  std::vector<grpc::Slice> slices = SlicesOf({.snapshot = snapshot, .chunks = {0}});

  snapshot.reset();
  EXPECT_FALSE(payload.expired());
  slices.clear();

  EXPECT_TRUE(payload.expired());
}

TEST(WireBuffers, TheBytesAreProtobufs) {
  const ChunkBatch batch{
      .update_id = 5, .topology_id = "t", .snapshot = TwoChunks(), .chunks = {0, 1}};
  std::string bytes;
  for (const grpc::Slice& slice : SlicesOf(batch)) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }

  v1::SceneEvent expected;
  v1::Chunks& chunks = *expected.mutable_chunks();
  chunks.set_update_id(5);
  chunks.set_topology_id("t");
  chunks.set_quantisation_id(3);
  for (uint32_t i = 0; i < 2; ++i) {
    const SnapshotChunk& chunk = batch.snapshot->chunks[i];
    v1::Chunk& added = *chunks.add_chunks();
    added.set_index(i);
    added.set_revision(chunk.revision);
    added.set_data(chunk.data.data, chunk.data.size);
  }
  EXPECT_TRUE(bytes == expected.SerializeAsString());
}

}  // namespace
}  // namespace latticed::testing
