// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/snapshot.h"

namespace latticed {
namespace {

std::shared_ptr<Snapshot> MakeSnapshot(uint64_t number, std::vector<SharedBytes> chunks) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->number = number;
  for (SharedBytes& chunk : chunks) snapshot->chunks.push_back({number, std::move(chunk)});
  return snapshot;
}

SharedBytes Chunk(size_t size) { return MakeSharedBytes(std::vector<uint8_t>(size)); }

TEST(SnapshotRing, KeepsTheNewestAndWhatIsPinned) {
  SnapshotRing ring;
  EXPECT_EQ(ring.PinNewest(), nullptr);
  ring.Publish(MakeSnapshot(1, {}));
  ring.Publish(MakeSnapshot(2, {}));
  EXPECT_EQ(ring.size(), 1u) << "nobody reads the first";
  EXPECT_EQ(ring.PinNewest()->number, 2u);
  ring.Publish(MakeSnapshot(3, {}));
  EXPECT_EQ(ring.newest()->number, 3u);
  EXPECT_NE(ring.Find(2), nullptr);

  ring.Unpin(2);
  EXPECT_EQ(ring.Find(2), nullptr);
  EXPECT_EQ(ring.size(), 1u);
}

TEST(SnapshotRing, RetiresTheOldestAboveThree) {
  SnapshotRing ring;
  for (uint64_t number = 1; number <= 4; ++number) {
    ring.Publish(MakeSnapshot(number, {}));
    EXPECT_EQ(ring.PinNewest()->number, number);
  }
  EXPECT_EQ(ring.size(), 3u);
  EXPECT_EQ(ring.Find(1), nullptr);
  ring.Unpin(1);  // retired: nothing to do
  EXPECT_NE(ring.Find(2), nullptr);
}

TEST(SnapshotRing, CountsSharedChunksOnce) {
  SnapshotRing ring;
  const SharedBytes shared = Chunk(100);
  ring.Publish(MakeSnapshot(1, {shared, Chunk(10)}));
  EXPECT_EQ(ring.bytes(), 110u);
  ring.PinNewest();
  ring.Publish(MakeSnapshot(2, {shared, Chunk(20)}));
  EXPECT_EQ(ring.bytes(), 130u);
  ring.Unpin(1);
  EXPECT_EQ(ring.bytes(), 120u);
}

}  // namespace
}  // namespace latticed
