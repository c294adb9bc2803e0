// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/memory/allocation_limit.h"

#include <gtest/gtest.h>

#include <new>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr size_t kLimit = 1'000'000;

std::vector<char> Block(size_t bytes) { return std::vector<char>(bytes); }

TEST(AllocationLimitTest, AThreadGetsWhatItMayHaveAtATimeAndNoMore) {
  const AllocationLimit limit(kLimit);

  for (int i = 0; i < 10; ++i) EXPECT_EQ(Block(900'000).size(), 900'000);
  const std::vector<char> kept = Block(600'000);

  EXPECT_THROW(Block(600'000), std::bad_alloc);
  EXPECT_EQ(Block(300'000).size(), 300'000);
}

TEST(AllocationLimitTest, RaisedLimitsCountFromTheBeginning) {
  AllocationLimit limit(kLimit);
  const std::vector<char> kept = Block(900'000);

  limit.Raise(2 * kLimit);
  EXPECT_EQ(Block(900'000).size(), 900'000);
  limit.Raise(kLimit);  // they never fall
  EXPECT_EQ(Block(900'000).size(), 900'000);

  EXPECT_THROW(Block(1'200'000), std::bad_alloc);
}

TEST(AllocationLimitTest, HoldsForNoOtherThreadAndNotWhilePausedOrAfterIt) {
  std::vector<char> paused, other;
  {
    const AllocationLimit limit(kLimit);
    std::thread([&other] { other = Block(2 * kLimit); }).join();
    {
      const AllocationLimit::Pause pause;
      paused = Block(2 * kLimit);
    }
    EXPECT_EQ(Block(900'000).size(), 900'000) << "what the pause took is not counted";
    EXPECT_THROW(Block(2 * kLimit), std::bad_alloc);
  }
  EXPECT_EQ(Block(2 * kLimit).size(), 2 * kLimit);
}

// A sequential Draco mesh of one face whose indices have a table of 38,400,000 symbols without probabilities, 64 a byte.
// libdraco takes 12 bytes for each.
TEST_F(SmallServerTest, ADracoFileGetsNoTablesThatItDoesNotAnnounce) {
  using namespace std::string_literals;
  const std::string header = "DRACO\2\2\1\0\0\0"s, counts = "\1\3\0"s, raw_symbols = "\1\x12"s;
  const std::string symbols = "\x80\xe0\xa7\x12"s;
  const std::string file = header + counts + raw_symbols + symbols + std::string(600'000, '\xff');
  v1::UploadMeshRequest upload;
  upload.mutable_header()->set_format(v1::MESH_FORMAT_DRACO);
  upload.mutable_header()->set_total_bytes(file.size());

  const absl::Status status = Upload(upload.header(), file);

  ExpectRefusal(
      status, {.reason = "MALFORMED_FILE",
               .field = "data",
               .message = "needs more memory than its points and faces explain, or than there is"});
  EXPECT_OK(DeleteMesh(SmallServerTest::Upload(CubeObj())));
}

}  // namespace
}  // namespace latticed::testing
