// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a writer of streams tells its caller, and when. Their bytes: draco_coder_test.cc and meshopt_coder_test.cc.
#include "cuda/streams/device_stream_writer.h"

#include <algorithm>

#include "cuda/draco/draco_coder.h"
#include "tests/cuda/streams/stream_coder_test.h"

namespace latticed::testing {
namespace {

class StreamWriterTest : public StreamCoderTest {
 protected:
  static std::vector<Chunk> Chunks(uint32_t count, Data data) {
    std::vector<Chunk> chunks;
    for (uint32_t i = 0; i < count; ++i) {
      chunks.push_back(MakeChunk(33, 14, 8, data, kSeed + i));
    }
    return chunks;
  }
  absl::StatusOr<DeviceStreamWriter> Writer(size_t part_bytes = DeviceStreamWriter::kPartBytes) {
    const DracoShape shape{.position_bits = 14, .normal_bits = 8, .is_sparse = true};
    return WriterWith(DracoCoder::Create(shape, *context_, lane_->stream().get()), part_bytes);
  }
};

TEST_F(StreamWriterTest, TellsEachResultOnceAndLeavesWhatWasTaken) {
  constexpr uint32_t kCount = 102;
  for (const size_t part_bytes : {DeviceStreamWriter::kPartBytes, kSmallParts}) {
    auto chunks = Chunks(kCount, Data::kRandom);
    ASSERT_OK_AND_ASSIGN(auto writer, Writer(part_bytes));
    std::vector<VertexDigest> digests(kCount);
    std::vector<SharedBytes> old(kCount);
    const auto places = PlacesOf(chunks, All(chunks));
    ASSERT_OK(writer.Encode(Upload(chunks).span(), places, 8, digests, old));
    for (uint32_t i = 0; i < kCount; i += 2) chunks[i].bytes[3] ^= 1;
    const auto vertices = Upload(chunks);
    const auto before = digests;
    ASSERT_OK_AND_ASSIGN(auto other, Writer());
    std::vector<SharedBytes> expected(kCount);
    ASSERT_OK(other.Encode(vertices.span(), places, 8, {}, expected));

    std::vector<SharedBytes> taken(kCount), results(kCount);
    std::vector<VertexDigest> found(kCount);
    std::vector<int> told(kCount);
    int calls = 0;
    const auto early = [&](size_t first, std::span<SharedBytes> some,
                           std::span<const VertexDigest> known) {
      ++calls;
      for (size_t k = 0; k < some.size(); ++k) {
        ++told[first + k];
        found[first + k] = known[k];
        taken[first + k] = std::exchange(some[k], SharedBytes());
      }
    };
    ASSERT_OK(writer.Encode(vertices.span(), places, 8, digests, results, early));

    EXPECT_EQ(calls, part_bytes == kSmallParts ? 4 : 1);
    EXPECT_EQ(found, digests);
    for (uint32_t i = 0; i < kCount; ++i) {
      ASSERT_EQ(told[i], 1) << i;
      ASSERT_EQ(results[i].data, nullptr) << i;
      ASSERT_EQ(digests[i] == before[i], i % 2 == 1) << i;
      const auto bytes = i % 2 == 0 ? expected[i].span() : std::span<const uint8_t>();
      ASSERT_TRUE(std::ranges::equal(taken[i].span(), bytes)) << i;
    }
  }
}

// Edits that move control points to and fro alternate between streams of few bytes and of many. A guess that was too small
// would be followed by a block of just the bytes.
TEST_F(StreamWriterTest, GuessesTheRoomForStreamsThatAlternate) {
  constexpr uint32_t kCount = 100;
  const auto small = Chunks(kCount, Data::kConstant), large = Chunks(kCount, Data::kRandom);
  const auto few = Upload(small), many = Upload(large);
  const auto places = PlacesOf(small, All(small));
  ASSERT_OK_AND_ASSIGN(auto writer, Writer());
  const auto encode = [&](const DeviceBuffer<uint8_t>& vertices) {
    std::vector<SharedBytes> results(kCount);
    EXPECT_OK(writer.Encode(vertices.span(), places, 8, {}, results));
    return results.front().block_bytes;
  };
  const size_t small_block = encode(few), large_block = encode(many);
  ASSERT_LT(2 * small_block, large_block);
  EXPECT_GE(encode(few), large_block);
  EXPECT_GE(encode(many), large_block);
  EXPECT_GE(encode(few), large_block);
  EXPECT_GE(encode(few), large_block) << "of the one before last";
  EXPECT_LT(encode(few), large_block) << "two rounds of few bytes";
}

}  // namespace
}  // namespace latticed::testing
