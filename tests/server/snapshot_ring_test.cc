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

constexpr absl::Time kStart = absl::UnixEpoch();

SharedBytes Chunk(size_t size) { return MakeSharedBytes(std::vector<uint8_t>(size)); }

TEST(SnapshotRing, KeepsTheNewestAndWhatIsPinned) {
  SnapshotRing ring;
  EXPECT_EQ(ring.PinNewest(kStart), nullptr);
  ring.Publish(MakeSnapshot(1, {}), kStart);
  ring.Publish(MakeSnapshot(2, {}), kStart);
  EXPECT_EQ(ring.size(), 1u) << "nobody reads the first";
  EXPECT_EQ(ring.PinNewest(kStart)->number, 2u);
  ring.Publish(MakeSnapshot(3, {}), kStart);
  EXPECT_EQ(ring.newest()->number, 3u);
  EXPECT_NE(ring.Find(2, kStart), nullptr);

  ring.Unpin(2);
  EXPECT_EQ(ring.Find(2, kStart), nullptr);
  EXPECT_EQ(ring.size(), 1u);
}

// Four snapshots that are pinned when they are published.
SnapshotRing FourPinned(absl::Time at_the_fourth) {
  SnapshotRing ring;
  for (uint64_t number = 1; number <= 4; ++number) {
    const absl::Time now = number == 4 ? at_the_fourth : kStart;
    EXPECT_EQ(ring.Publish(MakeSnapshot(number, {}), now), number == 4 ? 1u : 0u);
    EXPECT_EQ(ring.PinNewest(now)->number, number);
  }
  EXPECT_EQ(ring.size(), 3u);
  return ring;
}

TEST(SnapshotRing, RetiresAboveThreeAndLetsTheOldestGoOn) {
  SnapshotRing ring = FourPinned(kStart + SnapshotRing::kStalled / 2);

  EXPECT_EQ(ring.Find(2, kStart), nullptr);
  ring.Unpin(2);  // retired: nothing to do
  const absl::Time later = kStart + SnapshotRing::kStalled;
  EXPECT_NE(ring.Find(1, later), nullptr) << "looked at";
  EXPECT_EQ(ring.Publish(MakeSnapshot(5, {}), later), 1u);
  EXPECT_NE(ring.Find(1, later), nullptr);
  EXPECT_EQ(ring.Find(3, later), nullptr);
}

TEST(SnapshotRing, RetiresTheOldestOnceItStalls) {
  SnapshotRing ring = FourPinned(kStart + SnapshotRing::kStalled);

  EXPECT_EQ(ring.Find(1, kStart), nullptr);
  EXPECT_NE(ring.Find(2, kStart), nullptr);
}

TEST(SnapshotRing, CountsSharedChunksOnce) {
  SnapshotRing ring;
  const SharedBytes shared = Chunk(100);
  ring.Publish(MakeSnapshot(1, {shared, Chunk(10)}), kStart);
  EXPECT_EQ(ring.bytes(), 110u);
  ring.PinNewest(kStart);
  ring.Publish(MakeSnapshot(2, {shared, Chunk(20)}), kStart);
  EXPECT_EQ(ring.bytes(), 130u);
  ring.Unpin(1);
  EXPECT_EQ(ring.bytes(), 120u);
}

}  // namespace
}  // namespace latticed
