// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/device_group.h"

#include <gtest/gtest.h>

namespace latticed {
namespace {

using Shares = std::vector<size_t>;
using Free = std::vector<uint64_t>;

TEST(ChunkShares, AreEqualWhereEveryDeviceHasRoom) {
  EXPECT_EQ(ShareChunks(12, 10, Free{1'000, 40, 500}), (Shares{0, 4, 8, 12}));
  EXPECT_EQ(ShareChunks(10, 1, Free{100, 200, 300, 400}), (Shares{0, 3, 5, 8, 10}));
}

TEST(ChunkShares, FollowTheRoomWhereAnEqualShareDoesNotFit) {
  EXPECT_EQ(ShareChunks(12, 10, Free{300, 39, 261}), (Shares{0, 6, 7, 12}));
  EXPECT_EQ(ShareChunks(12, 10, Free{120, 0}), (Shares{0, 12, 12}));
}

TEST(ChunkShares, AreNoneWhereThereAreFewerChunksThanDevices) {
  EXPECT_EQ(ShareChunks(1, 10, Free{100, 100, 100}), (Shares{0, 0, 1, 1}));
}

// No device has enough memory. The device that is asked refuses, and says how much is free.
TEST(ChunkShares, AreEqualWhereNobodyHasRoom) {
  EXPECT_EQ(ShareChunks(4, 10, Free{0, 0}), (Shares{0, 2, 4}));
}

}  // namespace
}  // namespace latticed
