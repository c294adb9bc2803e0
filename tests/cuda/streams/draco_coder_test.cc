// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the device's Draco streams with the host's, byte for byte. Stock decoders check the host's
// streams (tests/core/codec/).
#include "cuda/draco/draco_coder.h"

#include <algorithm>
#include <random>

#include "core/base/limits.h"
#include "core/codec/draco_writer.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/cuda/streams/stream_coder_test.h"

namespace latticed::testing {
namespace {

constexpr double kRange = 8.0;

class DracoCoderTest : public StreamCoderTest {
 protected:
  struct Options {
    bool mesh = false;  // with triangles
    bool sparse = false;
    uint32_t entry_room = 0;
  };
  static DracoShape ShapeOf(const Chunk& chunk, bool sparse) {
    return {.position_bits = chunk.position_bits,
            .normal_bits = chunk.normal_bits,
            .is_sparse = sparse};
  }

  absl::StatusOr<DeviceStreamWriter> WriterOf(const DracoShape& shape, uint32_t entry_room = 0,
                                              size_t part_bytes = DeviceStreamWriter::kPartBytes) {
    return WriterWith(DracoCoder::Create(shape, *context_, lane_->stream().get(), entry_room),
                      part_bytes);
  }

  // Encodes those of `chunks` that `numbers` names, with both writers. Meshes may have two numbers of points, that of
  // the first chunk and that of the last.
  void ExpectTheHostsBytes(std::span<const Chunk> chunks, std::span<const uint32_t> numbers,
                           Options options) {
    const Chunk &first = chunks.front(), &last = chunks.back();
    const ChunkConnectivity triangles(first.points, Fan(first.points)),
        last_triangles(last.points, Fan(last.points));
    DracoShape shape = ShapeOf(first, options.sparse);
    if (options.mesh) {
      shape.connectivity = {&triangles, &last_triangles};
      shape.mesh_points = first.points;
    }
    const auto vertices = Upload(chunks);
    ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(shape, options.entry_room));
    std::vector<SharedBytes> results(numbers.size());
    ASSERT_OK(writer.Encode(vertices.span(), PlacesOf(chunks, numbers), kRange, {}, results));
    for (size_t i = 0; i < numbers.size(); ++i) {
      const Chunk& chunk = chunks[numbers[i]];
      QuantisedVertices one = chunk.vertices();
      one.is_sparse = options.sparse;
      const ChunkConnectivity* its = chunk.points == first.points ? &triangles : &last_triangles;
      std::vector<uint8_t> expected;
      ASSERT_OK(
          DracoWriter().Encode({&one, 1}, kRange, options.mesh ? its : nullptr, {&expected, 1}));
      ASSERT_TRUE(std::ranges::equal(results[i].span(), expected))
          << "chunk " << numbers[i] << " of " << chunk.points << " points, " << chunk.position_bits
          << " and " << chunk.normal_bits << " bits: " << results[i].size << " bytes for "
          << expected.size() << ", seed " << kSeed;
    }
  }
};

// With these numbers of points, whole chunks end at multiples of 4 bytes, as 32 patches do.
TEST_F(DracoCoderTest, AllSizesAndBits) {
  for (const size_t points : {4u, 96u, 2112u, 17'952u}) {
    for (int position_bits = 8; position_bits <= 16; ++position_bits) {
      const int normal_bits = position_bits == 8 ? 0 : std::max(position_bits - 4, 6);
      const auto chunks = AllKinds(points, position_bits, normal_bits);
      ExpectTheHostsBytes(chunks, All(chunks), {});
      if (HasFatalFailure()) return;
    }
  }
}

// Whole chunks, as in a scene.
TEST_F(DracoCoderTest, EveryNumberOfSegments) {
  for (int segments = limits::kMinSegments; segments <= limits::kMaxSegments; ++segments) {
    const int points = limits::kPatchesPerChunk * PointsPerPatch(segments);
    const auto chunks = AllKinds(static_cast<size_t>(points), 12, 8);
    ExpectTheHostsBytes(chunks, All(chunks), {});
    if (HasFatalFailure()) FAIL() << segments << " segments";
  }
}

TEST_F(DracoCoderTest, AllPairsOfBitsAsCloudsAndMeshes) {
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : {0, 6, 7, 8, 9, 10, 11, 12}) {
      const auto chunks = AllKinds(2112, position_bits, normal_bits);
      for (const bool mesh : {false, true}) {
        ExpectTheHostsBytes(chunks, All(chunks), {.mesh = mesh});
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST_F(DracoCoderTest, TheLargestChunk) {
  std::vector<Chunk> chunks;
  for (const Data data : kAllData) chunks.push_back(MakeChunk(65'532, 16, 12, data, kSeed));
  ExpectTheHostsBytes(chunks, All(chunks), {});
}

TEST_F(DracoCoderTest, SomeOfTheChunks) {
  const auto chunks = AllKinds(2112, 14, 10);
  ExpectTheHostsBytes(chunks, std::vector<uint32_t>{1, 4, 5, 14}, {});
  ExpectTheHostsBytes(chunks, std::vector<uint32_t>{7}, {});
  ExpectTheHostsBytes(chunks, std::vector<uint32_t>{14}, {.mesh = true});
}

// More chunks than sets of wide counts, where each chunk needs a set; and space for one table at a time.
TEST_F(DracoCoderTest, MemoryThatChunksWaitFor) {
  std::vector<Chunk> chunks;
  for (unsigned i = 0; i < 3 * kernels::kWideSlots; ++i) {
    chunks.push_back(MakeChunk(2112, 16, 8, Data::kRandom, kSeed + i));
  }
  ExpectTheHostsBytes(chunks, All(chunks), {});
  ExpectTheHostsBytes(std::span(chunks).first(5), All(std::span(chunks).first(5)),
                      {.entry_room = 1});
}

// From a chunk of one point to one of more than a ranking has room for.
TEST_F(DracoCoderTest, SparseChunksOfAllSizesAndBits) {
  constexpr size_t kSizes[] = {1, 2, 3, 5, 31, 97, 128, 129, 255, 300, 683, 1023, 1024, 1025, 2113};
  for (const auto& [position_bits, normal_bits] :
       {std::pair(8, 0), {8, 6}, {12, 0}, {12, 8}, {14, 8}, {14, 9}, {16, 0}, {16, 8}, {16, 12}}) {
    const auto chunks = ChunksOf(kSizes, position_bits, normal_bits);
    ExpectTheHostsBytes(chunks, All(chunks), {.sparse = true});
    if (HasFatalFailure()) return;
    ExpectTheHostsBytes(chunks, All(chunks), {});
    if (HasFatalFailure()) return;
  }
}

TEST_F(DracoCoderTest, SparseChunksOfRandomSizesInAnyOrder) {
  std::mt19937 random(kSeed);
  std::vector<Chunk> chunks;
  for (unsigned i = 0; i < 300; ++i) {
    const size_t points = 1 + random() % (i % 16 == 0 ? 1200 : 130);
    const Data data = kAllData[random() % std::size(kAllData)];
    chunks.push_back(MakeChunk(points, 14, 10, data, kSeed + i));
  }
  std::vector<uint32_t> numbers = All(chunks);
  std::ranges::shuffle(numbers, random);
  numbers.resize(200);
  ExpectTheHostsBytes(chunks, numbers, {.sparse = true});
  ExpectTheHostsBytes(chunks, All(chunks), {.sparse = true, .entry_room = 1});
}

TEST_F(DracoCoderTest, TheLargestSparseChunk) {
  constexpr size_t kSizes[] = {17'952, 4, 65'532};
  const auto chunks = ChunksOf(kSizes, 16, 12);
  ExpectTheHostsBytes(chunks, All(chunks), {.sparse = true});
}

// The chunk of a flat part of the surface: all points and normals are the same.
TEST_F(DracoCoderTest, OnePointManyTimes) {
  std::vector<Chunk> chunks;
  for (const size_t points : {1u, 2u, 96u, 1500u}) {
    chunks.push_back(MakeChunk(points, 14, 8, Data::kConstant, kSeed));
  }
  ExpectTheHostsBytes(chunks, All(chunks), {.sparse = true});
}

// Integers beyond the bits of a view are an error, also where tables have no place for them.
TEST_F(DracoCoderTest, RefusesMoreBitsThanTheViewHas) {
  for (const size_t points : {97u, 2112u}) {
    const Chunk chunk = MakeChunk(points, 16, 8, Data::kRandom, kSeed);
    const auto vertices = Upload({&chunk, 1});
    DracoShape shape = ShapeOf(chunk, true);
    shape.position_bits = 10;
    ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(shape, 1));
    SharedBytes result;
    const std::vector<uint32_t> first{0};
    EXPECT_THAT(
        writer.Encode(vertices.span(), PlacesOf({&chunk, 1}, first), kRange, {}, {&result, 1}),
        StatusIs(absl::StatusCode::kInternal));
  }
}

TEST_F(DracoCoderTest, WhatTheCallerHasIsNotWritten) {
  std::vector<Chunk> chunks = AllKinds(2112, 12, 8);
  const auto numbers = All(chunks);
  ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(ShapeOf(chunks.front(), false)));
  std::vector<VertexDigest> digests(chunks.size());
  const auto encode = [&] {
    const auto vertices = Upload(chunks);
    std::vector<SharedBytes> results(chunks.size());
    EXPECT_OK(writer.Encode(vertices.span(), PlacesOf(chunks, numbers), kRange, digests, results));
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

// The same chunks at other places, which need not be multiples of eight bytes.
TEST_F(DracoCoderTest, DigestsDoNotDependOnPlaces) {
  constexpr size_t kSizes[] = {5, 97, 1200};
  const auto chunks = ChunksOf(kSizes, 14, 0);
  const auto vertices = Upload(chunks);
  std::vector<Chunk> moved = chunks;
  moved.insert(moved.begin(), MakeChunk(7, 14, 0, Data::kRandom, kSeed));
  const auto others = Upload(moved);
  ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(ShapeOf(chunks.front(), true)));
  std::vector<VertexDigest> digests(chunks.size());
  std::vector<SharedBytes> results(chunks.size());
  ASSERT_OK(
      writer.Encode(vertices.span(), PlacesOf(chunks, All(chunks)), kRange, digests, results));
  const std::vector<VertexDigest> before = digests;
  auto places = PlacesOf(moved, All(moved));
  places.erase(places.begin());
  std::vector<SharedBytes> again(chunks.size());
  ASSERT_OK(writer.Encode(others.span(), places, kRange, digests, again));

  EXPECT_EQ(digests, before);
  for (size_t i = 0; i < chunks.size(); ++i) {
    EXPECT_NE(results[i].data, nullptr);
    EXPECT_EQ(again[i].data, nullptr);
  }
}

// A writer guesses the room for its streams from those before. Each part has its room.
TEST_F(DracoCoderTest, StreamsAreWholeWhereTheyTakeMoreOrLessThanTheLastOnes) {
  constexpr unsigned kCount = 130;
  for (const size_t part_bytes : {DeviceStreamWriter::kPartBytes, kSmallParts}) {
    std::vector<Chunk> small, large, mixed;
    for (unsigned i = 0; i < kCount; ++i) {
      small.push_back(MakeChunk(97, 14, 8, Data::kConstant, kSeed + i));
      large.push_back(MakeChunk(97, 14, 8, Data::kRandom, kSeed + i));
      mixed.push_back(i % 8 == 0 ? large.back() : small.back());
    }
    ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(ShapeOf(small.front(), true), 0, part_bytes));
    for (const auto& chunks : {small, large, large, mixed, large, small, small}) {
      const auto vertices = Upload(chunks);
      std::vector<SharedBytes> results(chunks.size());

      ASSERT_OK(writer.Encode(vertices.span(), PlacesOf(chunks, All(chunks)), kRange, {}, results));

      for (size_t i = 0; i < chunks.size(); ++i) {
        QuantisedVertices one = chunks[i].vertices();
        one.is_sparse = true;
        std::vector<uint8_t> expected;
        ASSERT_OK(DracoWriter().Encode({&one, 1}, kRange, nullptr, {&expected, 1}));
        ASSERT_TRUE(std::ranges::equal(results[i].span(), expected))
            << "chunk " << i << ", parts of " << part_bytes << " bytes";
      }
    }
  }
}

// Of parts that are on their way at once, any may have chunks that did not change.
TEST_F(DracoCoderTest, DigestsOfPartsAreKeptApart) {
  constexpr uint32_t kCount = 210;
  std::vector<Chunk> chunks;
  for (uint32_t i = 0; i < kCount; ++i) {
    chunks.push_back(MakeChunk(33, 12, 8, Data::kRandom, kSeed + i));
  }
  ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(ShapeOf(chunks.front(), false), 0, kSmallParts));
  std::vector<VertexDigest> digests(kCount);
  const auto encode = [&] {
    const auto vertices = Upload(chunks);
    std::vector<SharedBytes> results(kCount);
    EXPECT_OK(
        writer.Encode(vertices.span(), PlacesOf(chunks, All(chunks)), kRange, digests, results));
    std::vector<uint32_t> written;
    for (uint32_t i = 0; i < kCount; ++i) {
      if (results[i].data != nullptr) written.push_back(i);
    }
    return written;
  };
  EXPECT_EQ(encode(), All(chunks));
  EXPECT_EQ(encode(), std::vector<uint32_t>{});
  const std::vector<uint32_t> changed{0, 7, 51, 52, 105, kCount - 1};
  for (const uint32_t i : changed) chunks[i].bytes.back() ^= 1;
  EXPECT_EQ(encode(), changed);
}

TEST_F(DracoCoderTest, RefusesMoreBitsThanTheViewHasInParts) {
  std::vector<Chunk> good, wide;
  for (uint32_t i = 0; i < 210; ++i) {
    good.push_back(MakeChunk(33, 10, 8, Data::kRandom, kSeed + i));
    wide.push_back(MakeChunk(33, 16, 8, Data::kRandom, kSeed + i));
  }
  ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(ShapeOf(good.front(), true), 0, kSmallParts));
  std::vector<VertexDigest> digests(good.size());
  const auto encode = [&](std::span<const Chunk> chunks) {
    const auto vertices = Upload(chunks);
    std::vector<SharedBytes> results(chunks.size());
    return writer.Encode(vertices.span(), PlacesOf(chunks, All(chunks)), kRange, digests, results);
  };
  ASSERT_OK(encode(good));
  const std::vector<VertexDigest> before = digests;

  EXPECT_THAT(encode(wide), StatusIs(absl::StatusCode::kInternal));

  EXPECT_EQ(digests, before);
  EXPECT_OK(encode(good));
}

// Also where the streams of all parts take more than the room that was guessed for them.
TEST_F(DracoCoderTest, RefusedMemoryChangesNoDigest) {
  constexpr uint32_t kCount = 210;
  std::vector<Chunk> small, large;
  for (uint32_t i = 0; i < kCount; ++i) {
    small.push_back(MakeChunk(33, 14, 8, Data::kConstant, kSeed + i));
    large.push_back(MakeChunk(33, 14, 8, Data::kRandom, kSeed + i));
  }
  int left = -1;  // allocations before the one that is refused; negative: none is
  ASSERT_OK_AND_ASSIGN(context_, CudaContext::Create(0, {.refuse_allocation = [&](auto, uint64_t) {
                                                       return left >= 0 && left-- == 0;
                                                     }}));
  ASSERT_OK_AND_ASSIGN(lane_, context_->lanes().Borrow());
  const auto few = Upload(small), many = Upload(large);
  const auto places = PlacesOf(small, All(small));
  for (int refused = 0;; ++refused) {
    ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(ShapeOf(small.front(), true), 0, kSmallParts));
    std::vector<VertexDigest> digests(kCount);
    std::vector<SharedBytes> results(kCount);
    ASSERT_OK(writer.Encode(few.span(), places, kRange, digests, results));
    const std::vector<VertexDigest> before = digests;

    left = refused;
    const absl::Status status = writer.Encode(many.span(), places, kRange, digests, results);
    left = -1;

    if (status.ok()) {
      EXPECT_GE(refused, 14) << "four parts of three allocations, and two of the second block";
      EXPECT_NE(digests, before);
      return;
    }
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted)) << refused;
    ASSERT_EQ(digests, before) << refused;
    results.assign(kCount, {});
    ASSERT_OK(writer.Encode(many.span(), places, kRange, digests, results));
    for (uint32_t i = 0; i < kCount; ++i) ASSERT_NE(results[i].data, nullptr) << refused;
  }
}

// A round that writes nothing says nothing of the next one. The first call has nothing to go by, so its block is that of
// the streams, a little below a power of two; a guess of a sixteenth more takes the next one.
TEST_F(DracoCoderTest, TheGuessOfTheRoomOutlivesARoundWithoutStreams) {
  constexpr size_t kPowerOfTwo = 1 << 18;
  const std::vector<Chunk> one{MakeChunk(97, 14, 8, Data::kRandom, kSeed)};
  const auto vertices = Upload(one);
  ASSERT_OK_AND_ASSIGN(auto writer, WriterOf(ShapeOf(one.front(), true)));
  const auto encode = [&](size_t count, std::span<VertexDigest> digests) {
    const std::vector<DeviceStreamWriter::Chunk> places(count, {.first_point = 0, .points = 97});
    std::vector<SharedBytes> results(count);
    EXPECT_OK(writer.Encode(vertices.span(), places, kRange, digests, results));
    return results;
  };
  const size_t stream = kernels::RoundUpTo16(encode(1, {}).front().size);
  ASSERT_LT(stream, kPowerOfTwo / 100);
  const size_t count = kPowerOfTwo / stream;
  std::vector<VertexDigest> digests(count);
  ASSERT_OK_AND_ASSIGN(writer, WriterOf(ShapeOf(one.front(), true)));

  EXPECT_EQ(encode(count, digests).front().block_bytes, kPowerOfTwo);
  EXPECT_EQ(encode(count, digests).front().data, nullptr) << "nothing changed";
  std::ranges::fill(digests, VertexDigest{});
  EXPECT_EQ(encode(count, digests).front().block_bytes, 2 * kPowerOfTwo);
}

TEST_F(DracoCoderTest, NothingToEncode) {
  ASSERT_OK_AND_ASSIGN(auto writer, WriterOf({}));
  EXPECT_OK(writer.Encode({}, {}, kRange, {}, {}));
}

}  // namespace
}  // namespace latticed::testing
