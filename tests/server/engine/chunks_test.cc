// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/limits.h"
#include "server/engine/render/chunk_set.h"
#include "server/engine/render/chunk_table.h"
#include "server/engine/render/encode_snapshot.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Chunks of three groups.
constexpr size_t kSize = 600;

NewChunk Chunk(uint64_t revision, uint8_t byte) { return {revision, MakeSharedBytes({byte}), {}}; }

ChunkTable MakeTable() {
  ChunkTable table(kSize);
  for (size_t c = 0; c < kSize; ++c) table.Set(c, Chunk(1, static_cast<uint8_t>(c)));
  return table;
}

// How many copies of a chunk's group there are.
long TablesWith(const ChunkTable& table, size_t chunk) {
  return table.Data(chunk).owner.use_count() - 1;
}

TEST(ChunkTable, WhatIsSetInACopyIsNotInTheOther) {
  const ChunkTable before = MakeTable();
  ChunkTable after = before.Share();
  ASSERT_EQ(after.size(), kSize);
  after.Set(300, Chunk(2, 0xff));
  after.Set(301, Chunk(2, 0xfe));

  EXPECT_EQ(before[300].revision, 1u);
  EXPECT_EQ(before[300].data[0], 300 % 256);
  EXPECT_EQ(after[300].data[0], 0xff);
  EXPECT_EQ(after[301].data[0], 0xfe);
  EXPECT_EQ(after[302].data.data(), before[302].data.data())
      << "of the same group, and the same bytes";
  EXPECT_EQ(TablesWith(before, 302), 2);
  EXPECT_EQ(TablesWith(before, 5), 1) << "a group that nothing was set in is shared";
  EXPECT_EQ(TablesWith(before, 599), 1);
}

TEST(ChunkTable, ADigestIsSetBesideTheSameBytes) {
  constexpr VertexDigest kDigest{.low = 1, .high = 2};
  const ChunkTable before = MakeTable();
  ChunkTable after = before.Share();

  after.SetDigest(300, kDigest);
  after.SetDigest(5, before[5].digest);

  EXPECT_EQ(after[300].digest, kDigest);
  EXPECT_EQ(after[300].revision, 1u);
  EXPECT_EQ(after[300].data.data(), before[300].data.data());
  EXPECT_EQ(before[300].digest, VertexDigest());
  EXPECT_EQ(TablesWith(before, 5), 1) << "a group where it was that already is shared";
  EXPECT_THAT(after.ChangedAfter(1), IsEmpty());
}

TEST(ChunkTable, ACopyOfACopyIsOneOfItsOwn) {
  const ChunkTable first = MakeTable();
  ChunkTable second = first.Share();
  second.Set(3, Chunk(2, 2));
  ChunkTable third = second.Share();
  third.Set(4, Chunk(3, 3));

  EXPECT_EQ(second[4].revision, 1u);
  EXPECT_EQ(third[3].revision, 2u);
  EXPECT_THAT(third.ChangedAfter(2), ElementsAre(4u));
  EXPECT_THAT(third.ChangedAfter(1), ElementsAre(3u, 4u));
}

TEST(ChunkTable, TellsWhatChangedInAllGroups) {
  ChunkTable table = MakeTable();
  for (const size_t c : {0u, 255u, 256u, 599u}) table.Set(c, Chunk(7, 0));
  EXPECT_THAT(table.ChangedAfter(6), ElementsAre(0u, 255u, 256u, 599u));
  EXPECT_THAT(table.ChangedAfter(7), IsEmpty());
  EXPECT_EQ(table.ChangedAfter(0).size(), kSize);
}

TEST(ChunkTable, KeepsTheBytesOfASharedGroupsChunks) {
  std::array<std::weak_ptr<const void>, 2> owners;
  ChunkTable before(kSize);
  for (size_t c = 0; c < owners.size(); ++c) {
    const NewChunk chunk = Chunk(1, static_cast<uint8_t>(c));
    owners[c] = chunk.data.owner;
    before.Set(c, chunk);
  }
  ChunkTable after = before.Share();
  after.Set(0, Chunk(2, 7));
  EXPECT_FALSE(owners[0].expired());

  before = ChunkTable();

  EXPECT_TRUE(owners[0].expired()) << "nothing else has it";
  EXPECT_FALSE(owners[1].expired());
  after.CopyData(1);
  EXPECT_TRUE(owners[1].expired());
  EXPECT_EQ(after[1].data[0], 1);
  EXPECT_EQ(after[1].revision, 1u);
  EXPECT_EQ(after.BytesOfNoBlock(), 2u);
}

// The first `size` bytes of `block`.
SharedBytes Part(const std::shared_ptr<std::vector<uint8_t>>& block, size_t size) {
  return {block, block->data(), size, block->size()};
}

TEST(ChunkTable, CountsBlocksOnceAndWhatIsUsedOfThem) {
  const auto one = std::make_shared<std::vector<uint8_t>>(1000);
  const auto other = std::make_shared<std::vector<uint8_t>>(500);
  ChunkTable before(kSize);
  for (size_t c = 0; c < kSize; ++c) before.Set(c, {1, Part(one, 5), {}});  // in three groups
  ASSERT_EQ(before.Blocks().size(), 1u);
  EXPECT_EQ(before.Blocks()[0].used, 3'000u);

  ChunkTable after = before.Share();
  for (size_t c = 250; c < 260; ++c) after.Set(c, {2, Part(other, 7), {}});
  after.Set(599, Chunk(2, 1));

  const std::vector<BlockUse> blocks = after.Blocks();
  ASSERT_EQ(blocks.size(), 2u);
  for (const BlockUse& block : blocks) {
    EXPECT_EQ(block.bytes, block.owner == one.get() ? 1000u : 500u);
    EXPECT_EQ(block.used, block.owner == one.get() ? 589 * 5u : 70u);
  }
  EXPECT_EQ(after.BytesOfNoBlock(), 1u);
  EXPECT_EQ(before.Blocks()[0].used, 3'000u);

  for (size_t c = 250; c < 260; ++c) after.Set(c, Chunk(3, 1));
  EXPECT_EQ(after.Blocks().size(), 1u) << "nothing is left of the other";
}

TEST(ChunkTable, OfNothingAndOfOneGroup) {
  EXPECT_EQ(ChunkTable().size(), 0u);
  EXPECT_THAT(ChunkTable().ChangedAfter(0), IsEmpty());
  ChunkTable one(256);
  one.Set(255, Chunk(1, 1));
  EXPECT_THAT(one.ChangedAfter(0), ElementsAre(255u));
}

using Chunks = std::vector<uint32_t>;

TEST(ChunkSet, TakesWhatWasAddedOnce) {
  ChunkSet set;
  set.Add(Chunks{1, 5});
  set.Add(Chunks{1, 3});

  EXPECT_FALSE(set.all());
  EXPECT_EQ(set.Take(6), (Chunks{1, 3, 5}));
  EXPECT_TRUE(set.Take(6).empty());
}

TEST(ChunkSet, AllAreThoseOfThePlanThatTakesThem) {
  ChunkSet set = ChunkSet::All();
  set.Add(Chunks{7});

  EXPECT_TRUE(set.all());
  EXPECT_EQ(set.Take(3), (Chunks{0, 1, 2}));
  EXPECT_FALSE(set.all());
  EXPECT_TRUE(set.Take(3).empty());
}

TEST(ChunkSet, ForgetsWhatASmallerPlanDoesNotHave) {
  ChunkSet set;
  set.Add(Chunks{2, 9});

  EXPECT_EQ(set.Take(4), (Chunks{2}));
  EXPECT_TRUE(set.Take(20).empty());
}

// A view without a device: its vertices are their own digest, and encoding them gives them.
class EncodeSnapshotTest : public ::testing::Test {
 protected:
  EncodeSnapshotTest() {
    auto plan = std::make_shared<DeformPlan>();
    plan->patches.resize(2 * limits::kPatchesPerChunk);
    state_.plan = std::move(plan);
  }
  std::shared_ptr<Snapshot> Encode(const Snapshot* before,
                                   std::span<const uint64_t> revisions = {}) {
    ++state_.revision;
    const uint32_t chunks[] = {0, 1};
    auto snapshot = EncodeSnapshot(
        key_, state_, chunks, revisions, {}, before,
        [&](std::span<const uint32_t> some, KnownDigests known, TakeEarly) {
          const std::span<VertexDigest> digests = known();
          std::vector<SharedBytes> encoded(some.size());
          for (size_t i = 0; i < some.size(); ++i) {
            const VertexDigest digest{vertices_[some[i]], 1};
            if (std::exchange(digests[i], digest) == digest) continue;
            ++encoded_;
            encoded[i] = MakeSharedBytes({vertices_[some[i]]});
          }
          return encoded;
        },
        PatternsOf(patterns_));
    return *snapshot;
  }

  // Some results are taken early, in an attempt that fails, and all of them in another one.
  std::shared_ptr<Snapshot> EncodeInTwoAttempts(const Snapshot* before,
                                                const std::vector<uint8_t>& bytes) {
    ++state_.revision;
    const uint32_t chunks[] = {0, 1};
    auto snapshot = EncodeSnapshot(
        {}, state_, chunks, {}, {}, before,
        [&](std::span<const uint32_t>, KnownDigests known, TakeEarly early) {
          known();
          // Of another writer.
          const VertexDigest found[] = {{vertices_[0] ^ 1u, 2}, {vertices_[1] ^ 1u, 2}};
          std::vector<SharedBytes> failed = {MakeSharedBytes({1, 2, 3}), MakeSharedBytes({4})};
          early(0, failed, found);
          const std::span<VertexDigest> digests = known();
          std::vector<SharedBytes> encoded = {MakeSharedBytes({vertices_[0]}),
                                              MakeSharedBytes(bytes)};
          early(1, std::span(encoded).subspan(1), std::span(found).subspan(1));
          const bool may_be_equal = before->chunks[1].data.size() == bytes.size() &&
                                    !before->chunks[1].digest.DiffersForSure(found[1]);
          EXPECT_EQ(encoded[1].data != nullptr, may_be_equal) << "else it was taken";
          std::ranges::copy(found, digests.begin());
          return encoded;
        },
        PatternCodes());
    return *snapshot;
  }

  static PatternCodes PatternsOf(const std::vector<uint16_t>& codes) {
    const auto copy = std::make_shared<const std::vector<uint16_t>>(codes);
    return {copy, *copy};
  }

  SceneState state_;
  std::array<uint8_t, 2> vertices_ = {5, 6};
  ViewKey key_;
  std::vector<uint16_t> patterns_;
  size_t encoded_ = 0;
};

TEST_F(EncodeSnapshotTest, AnotherPatternIsAChangeWhateverTheBytes) {
  patterns_.assign(2 * limits::kPatchesPerChunk, 1);
  const auto first = Encode(nullptr);
  const auto second = Encode(first.get());
  EXPECT_EQ(encoded_, 2u) << "nothing has changed";
  EXPECT_EQ(second->chunks[1].revision, 1u);

  patterns_.back() = 8;
  const auto third = Encode(second.get());

  EXPECT_EQ(encoded_, 2u) << "the same vertices have the same bytes";
  EXPECT_EQ(third->chunks[0].revision, 1u);
  EXPECT_EQ(third->chunks[1].revision, 3u);
  EXPECT_THAT(third->chunks[1].data, ElementsAre(6));
  EXPECT_EQ(third->patterns.OfChunk(1).back(), 8);
  EXPECT_EQ(second->patterns.OfChunk(1).back(), 1);
  EXPECT_THAT(third->chunks.ChangedAfter(2), ElementsAre(1));
}

// A mesh has other bytes where the same vertices have other triangles.
TEST_F(EncodeSnapshotTest, AMeshWithOtherPatternsIsEncodedAgain) {
  key_.encoding = Encoding::kDracoMesh;
  patterns_.assign(2 * limits::kPatchesPerChunk, 1);
  const auto first = Encode(nullptr);
  patterns_.back() = 8;
  const auto second = Encode(first.get());

  EXPECT_EQ(encoded_, 3u);
  EXPECT_THAT(second->chunks.ChangedAfter(1), ElementsAre(1)) << "though the bytes are the same";
}

TEST_F(EncodeSnapshotTest, WhatHasNoDataAndHadNoneIsEmpty) {
  const uint32_t chunks[] = {0, 1};
  const auto none = [](std::span<const uint32_t> some, KnownDigests known, TakeEarly early) {
    const std::span<VertexDigest> digests = known();
    std::vector<SharedBytes> results(some.size());
    early(0, std::span(results).first(1), digests.first(1));
    return results;
  };
  const auto snapshot = EncodeSnapshot(key_, state_, chunks, {}, {}, nullptr, none, {});

  ASSERT_OK(snapshot);
  EXPECT_TRUE((*snapshot)->chunks[0].data.empty());
  EXPECT_TRUE((*snapshot)->chunks[1].data.empty());
}

TEST_F(EncodeSnapshotTest, WhatIsTakenEarlyIsWhatTheLastAttemptSays) {
  const auto first = Encode(nullptr);
  const auto second = EncodeInTwoAttempts(first.get(), {6, 9});

  EXPECT_THAT(second->chunks[0].data, ElementsAre(5));
  EXPECT_EQ(second->chunks[0].digest, (VertexDigest{4, 2}));
  EXPECT_THAT(second->chunks[1].data, ElementsAre(6, 9));
  EXPECT_EQ(second->chunks[1].digest, (VertexDigest{7, 2}));
  EXPECT_EQ(second->chunks[1].revision, 2u);
  EXPECT_EQ(second->held_bytes, 3u);

  EXPECT_EQ(second->chunks[0].revision, 1u);
  const auto third = EncodeInTwoAttempts(second.get(), {7, 9});
  EXPECT_THAT(third->chunks[1].data, ElementsAre(7, 9)) << "of the same size";
  EXPECT_EQ(third->chunks[1].revision, 3u);
  const auto fourth = EncodeInTwoAttempts(third.get(), {7, 9});
  EXPECT_EQ(fourth->chunks[1].revision, 3u) << "the same bytes";
  vertices_[1] = 8;
  ASSERT_TRUE(fourth->chunks[1].digest.DiffersForSure({9, 2}));
  const auto fifth = EncodeInTwoAttempts(fourth.get(), {8, 9});
  EXPECT_THAT(fifth->chunks[1].data, ElementsAre(8, 9)) << "not compared, but of other vertices";
  EXPECT_EQ(fifth->chunks[1].revision, 5u);
}

}  // namespace
}  // namespace latticed
