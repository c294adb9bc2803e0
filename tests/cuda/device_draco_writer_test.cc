// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the device's writer with the host's, byte for byte. Stock decoders check the host's
// streams (tests/core/codec/).
#include "cuda/draco/device_draco_writer.h"

#include <algorithm>

#include "core/base/limits.h"
#include "core/codec/draco_writer.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

constexpr unsigned kSeed = 20'261'121;
constexpr double kRange = 8.0;

class DeviceDracoWriterTest : public CudaTest {
 protected:
  DeviceDracoWriterTest() : CudaTest(kSeed) {}

  void SetUp() override {
    CudaTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    ASSERT_OK_AND_ASSIGN(context_, CudaContext::Create(0, {.poison_memory = true}));
    ASSERT_OK_AND_ASSIGN(lane_, context_->lanes().Borrow());
  }

  DeviceBuffer<uint8_t> Upload(std::span<const Chunk> chunks) {
    std::vector<uint8_t> bytes;
    for (const Chunk& chunk : chunks) {
      bytes.insert(bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
    }
    auto buffer = DeviceBuffer<uint8_t>::Upload(
        context_->memory(), "vertices", std::span<const uint8_t>(bytes), lane_->stream().get());
    EXPECT_OK(buffer);
    return *std::move(buffer);
  }

  // Encodes those of `chunks` that `numbers` names, with both writers. `mesh`: with triangles.
  void ExpectTheHostsBytes(std::span<const Chunk> chunks, std::span<const uint32_t> numbers,
                           bool mesh, uint32_t entry_room = 0) {
    const Chunk &first = chunks.front(), &last = chunks.back();
    const ChunkConnectivity triangles(first.points, Fan(first.points)),
        last_triangles(last.points, Fan(last.points));
    DracoShape shape{.points = first.points,
                     .last_points = last.points,
                     .position_bits = first.position_bits,
                     .normal_bits = first.normal_bits};
    if (mesh) shape.connectivity = {&triangles, &last_triangles};
    const auto vertices = Upload(chunks);
    ASSERT_OK_AND_ASSIGN(auto writer, DeviceDracoWriter::Create(shape, context_, lane_));
    std::vector<SharedBytes> results(numbers.size());
    const auto last_number = static_cast<uint32_t>(chunks.size()) - 1;
    ASSERT_OK(
        writer.Encode({vertices.span(), last_number}, numbers, kRange, {}, results, entry_room));
    for (size_t i = 0; i < numbers.size(); ++i) {
      const Chunk& chunk = chunks[numbers[i]];
      const QuantisedVertices one = chunk.vertices();
      const ChunkConnectivity& its = numbers[i] == last_number ? last_triangles : triangles;
      std::vector<uint8_t> expected;
      ASSERT_OK(DracoWriter().Encode({&one, 1}, kRange, mesh ? &its : nullptr, {&expected, 1}));
      ASSERT_TRUE(std::ranges::equal(results[i].span(), expected))
          << "chunk " << numbers[i] << " of " << chunk.points << " points, " << chunk.position_bits
          << " and " << chunk.normal_bits << " bits: " << results[i].size << " bytes for "
          << expected.size() << ", seed " << kSeed;
    }
  }

  // Full chunks of each kind of data, then a smaller last one.
  static std::vector<Chunk> AllKinds(size_t points, int position_bits, int normal_bits) {
    std::vector<Chunk> chunks;
    constexpr unsigned kKinds = std::size(kAllData);
    for (unsigned i = 0; i < 2 * kKinds; ++i) {
      chunks.push_back(
          MakeChunk(points, position_bits, normal_bits, kAllData[i % kKinds], kSeed + i));
    }
    chunks.push_back(MakeChunk((points + 2) / 3, position_bits, normal_bits, Data::kWalk, kSeed));
    return chunks;
  }
  static std::vector<uint32_t> All(std::span<const Chunk> chunks) {
    std::vector<uint32_t> numbers(chunks.size());
    for (uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
    return numbers;
  }

  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
};

// With these numbers of points, whole chunks end at multiples of 4 bytes, as 32 patches do.
TEST_F(DeviceDracoWriterTest, AllSizesAndBits) {
  for (const size_t points : {4u, 96u, 2112u, 17'952u}) {
    for (int position_bits = 8; position_bits <= 16; ++position_bits) {
      const int normal_bits = position_bits == 8 ? 0 : std::max(position_bits - 4, 6);
      const auto chunks = AllKinds(points, position_bits, normal_bits);
      ExpectTheHostsBytes(chunks, All(chunks), false);
      if (HasFatalFailure()) return;
    }
  }
}

// Whole chunks, as in a scene.
TEST_F(DeviceDracoWriterTest, EveryNumberOfSegments) {
  for (int segments = limits::kMinSegments; segments <= limits::kMaxSegments; ++segments) {
    const int points = limits::kPatchesPerChunk * PointsPerPatch(segments);
    const auto chunks = AllKinds(static_cast<size_t>(points), 12, 8);
    ExpectTheHostsBytes(chunks, All(chunks), false);
    if (HasFatalFailure()) FAIL() << segments << " segments";
  }
}

TEST_F(DeviceDracoWriterTest, AllPairsOfBitsAsCloudsAndMeshes) {
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : {0, 6, 7, 8, 9, 10, 11, 12}) {
      const auto chunks = AllKinds(2112, position_bits, normal_bits);
      for (const bool mesh : {false, true}) {
        ExpectTheHostsBytes(chunks, All(chunks), mesh);
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST_F(DeviceDracoWriterTest, TheLargestChunk) {
  std::vector<Chunk> chunks;
  for (const Data data : kAllData) chunks.push_back(MakeChunk(65'532, 16, 12, data, kSeed));
  ExpectTheHostsBytes(chunks, All(chunks), false);
}

TEST_F(DeviceDracoWriterTest, SomeOfTheChunks) {
  const auto chunks = AllKinds(2112, 14, 10);
  ExpectTheHostsBytes(chunks, std::vector<uint32_t>{1, 4, 5, 14}, false);
  ExpectTheHostsBytes(chunks, std::vector<uint32_t>{7}, false);
  ExpectTheHostsBytes(chunks, std::vector<uint32_t>{14}, true);
}

// More chunks than sets of wide counts, where each chunk needs a set; and space for one table at a time.
TEST_F(DeviceDracoWriterTest, MemoryThatChunksWaitFor) {
  std::vector<Chunk> chunks;
  for (unsigned i = 0; i < 3 * kernels::kWideSlots; ++i) {
    chunks.push_back(MakeChunk(2112, 16, 8, Data::kRandom, kSeed + i));
  }
  ExpectTheHostsBytes(chunks, All(chunks), false);
  ExpectTheHostsBytes(std::span(chunks).first(5), All(std::span(chunks).first(5)), false, 1);
}

TEST_F(DeviceDracoWriterTest, WhatTheCallerHasIsNotWritten) {
  std::vector<Chunk> chunks = AllKinds(2112, 12, 8);
  const auto numbers = All(chunks);
  ASSERT_OK_AND_ASSIGN(auto writer,
                       DeviceDracoWriter::Create(
                           {.points = 2112, .last_points = chunks.back().points, .normal_bits = 8},
                           context_, lane_));
  std::vector<VertexDigest> digests(chunks.size());
  const auto encode = [&] {
    const auto vertices = Upload(chunks);
    std::vector<SharedBytes> results(chunks.size());
    const auto last = static_cast<uint32_t>(chunks.size()) - 1;
    EXPECT_OK(writer.Encode({vertices.span(), last}, numbers, kRange, digests, results));
    std::vector<uint32_t> written;
    for (const uint32_t i : numbers) {
      if (results[i].data != nullptr) written.push_back(i);
    }
    return written;
  };
  EXPECT_EQ(encode(), numbers);
  EXPECT_EQ(encode(), std::vector<uint32_t>{});
  chunks[3].bytes[4222] ^= 1;       // the last x
  chunks.back().bytes.back() ^= 1;  // the last t
  EXPECT_EQ(encode(), (std::vector<uint32_t>{3, 14}));
  std::swap(chunks[1].bytes[0], chunks[1].bytes[8]);
  std::swap(chunks[1].bytes[1], chunks[1].bytes[9]);
  EXPECT_EQ(encode(), std::vector<uint32_t>{}) << "constant data";
  std::swap(chunks[4].bytes[0], chunks[4].bytes[8]);
  EXPECT_EQ(encode(), std::vector<uint32_t>{4}) << "sums know places";
}

TEST_F(DeviceDracoWriterTest, NothingToEncode) {
  ASSERT_OK_AND_ASSIGN(
      auto writer, DeviceDracoWriter::Create({.points = 96, .last_points = 96}, context_, lane_));
  EXPECT_OK(writer.Encode({}, {}, kRange, {}, {}));
}

}  // namespace
}  // namespace latticed::testing
