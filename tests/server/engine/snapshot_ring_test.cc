// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/engine/render/chunk_blocks.h"
#include "server/engine/render/snapshot_ring.h"

namespace latticed {
namespace {

std::shared_ptr<Snapshot> MakeSnapshot(uint64_t number, std::vector<SharedBytes> chunks) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->number = number;
  snapshot->chunks = ChunkTable(chunks.size());
  for (size_t c = 0; c < chunks.size(); ++c) {
    snapshot->chunks.Set(c, {number, std::move(chunks[c]), {}});
  }
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

  EXPECT_EQ(ring.Unpin(2)->number, 2u);
  EXPECT_EQ(ring.Find(2, kStart), nullptr);
  EXPECT_EQ(ring.size(), 1u);
}

// A ring to which four snapshots were published, each pinned at once.
SnapshotRing FourPinned(absl::Time at_the_fourth) {
  SnapshotRing ring;
  for (uint64_t number = 1; number <= 4; ++number) {
    const absl::Time now = number == 4 ? at_the_fourth : kStart;
    EXPECT_EQ(ring.Publish(MakeSnapshot(number, {}), now).retired, number == 4 ? 1u : 0u);
    EXPECT_EQ(ring.PinNewest(now)->number, number);
  }
  EXPECT_EQ(ring.size(), 3u);
  return ring;
}

TEST(SnapshotRing, RetiresAboveThreeAndLetsTheOldestGoOn) {
  SnapshotRing ring = FourPinned(kStart + SnapshotRing::kStalled / 2);

  EXPECT_EQ(ring.Find(2, kStart), nullptr);
  EXPECT_EQ(ring.Unpin(2), nullptr) << "retired: nothing to do";
  const absl::Time later = kStart + SnapshotRing::kStalled;
  EXPECT_NE(ring.Find(1, later), nullptr) << "looked at";
  EXPECT_EQ(ring.Publish(MakeSnapshot(5, {}), later).retired, 1u);
  EXPECT_NE(ring.Find(1, later), nullptr);
  EXPECT_EQ(ring.Find(3, later), nullptr);
}

TEST(SnapshotRing, RetiresTheOldestOnceItStalls) {
  SnapshotRing ring = FourPinned(kStart + SnapshotRing::kStalled);

  EXPECT_EQ(ring.Find(1, kStart), nullptr);
  EXPECT_NE(ring.Find(2, kStart), nullptr);
}

TEST(SnapshotRing, RetiresWhatDoesNotFitBesideTheNewest) {
  SnapshotRing ring;
  for (uint64_t number = 1; number <= 3; ++number) {
    auto snapshot = MakeSnapshot(number, {});
    snapshot->held_bytes = 100;
    EXPECT_EQ(ring.Publish(snapshot, kStart, 250).retired, number == 3 ? 1u : 0u);
    ring.PinNewest(kStart);
  }
  EXPECT_NE(ring.Find(1, kStart), nullptr) << "the oldest goes on";
  EXPECT_EQ(ring.Find(2, kStart), nullptr);

  auto large = MakeSnapshot(4, {});
  large->held_bytes = 300;
  EXPECT_EQ(ring.Publish(large, kStart, 250).retired, 2u);
  EXPECT_EQ(ring.newest()->number, 4u) << "the newest always stays";
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

// Chunks of `sizes` bytes, one after the other in one block.
std::vector<SharedBytes> Block(const std::vector<size_t>& sizes, uint8_t fill) {
  const size_t all = std::accumulate(sizes.begin(), sizes.end(), size_t{0});
  const auto block = std::make_shared<std::vector<uint8_t>>(all, fill);
  std::vector<SharedBytes> parts;
  size_t at = 0;
  for (const size_t size : sizes) {
    parts.push_back({block, block->data() + at, size, all});
    at += size;
  }
  return parts;
}

TEST(ChunkBlocks, ChunksLeaveBlocksThatAreMostlyUnused) {
  const auto old = Block({100, 100, 100, 100}, 1), recent = Block({100, 100, 100}, 2);
  auto snapshot = MakeSnapshot(1, {old[0], recent[0], recent[1], recent[2]});
  ASSERT_EQ(HeldBytes(snapshot->chunks), 700u);
  const std::weak_ptr<const void> forgotten = old[0].owner;

  LeaveEmptyBlocks(*snapshot);

  EXPECT_EQ(HeldBytes(snapshot->chunks), 400u) << "a block of 300, and a copy";
  EXPECT_NE(snapshot->chunks.Data(0).owner, old[0].owner);
  EXPECT_EQ(snapshot->chunks[0].data.size(), 100u);
  EXPECT_EQ(snapshot->chunks[0].data[99], 1);
  EXPECT_EQ(snapshot->chunks[1].data.data(), recent[0].data) << "in its block, which is in use";
}

// Each update makes four chunks in one block. Three replace old chunks; in turn, one old chunk stays.
TEST(ChunkBlocks, ManyUpdatesHoldNoMoreThanFourTimesWhatTheyUse) {
  auto snapshot = MakeSnapshot(1, Block({100, 100, 100, 100}, 0));
  for (size_t update = 0; update < 100; ++update) {
    const auto made = Block({100, 100, 100, 100}, static_cast<uint8_t>(update));
    const size_t kept = update % 4;
    for (size_t i = 0; i < 4; ++i) {
      if (i != kept) snapshot->chunks.Set(i, {1, made[i], {}});
    }
    KeepBlocksFew(*snapshot);
    ASSERT_LE(HeldBytes(snapshot->chunks), 1600u) << "update " << update;
    ASSERT_EQ(snapshot->held_bytes, HeldBytes(snapshot->chunks)) << "update " << update;
  }
}

}  // namespace
}  // namespace latticed
