// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Our decoder against the integers that our writer was given, and against libdraco on damaged streams. This program counts
// allocations.
#include "client/decoder/chunk_decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "client/decoder/lanes/lane_kernel.h"
#include "core/codec/chunk_connectivity.h"
#include "core/codec/draco_writer.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/instruction_sets.h"

namespace latticed::decoder {
namespace {

using latticed::testing::Chunk;
using latticed::testing::Data;
using latticed::testing::kAllData;
using latticed::testing::MakeChunk;

constexpr size_t kGuard = 16;
constexpr uint16_t kUntouched = 0xA55A;

struct Decoded {
  std::vector<std::vector<uint16_t>> points;  // with kGuard numbers behind
  std::vector<ChunkJob> jobs;
};

Decoded DecodeAll(const ChunkForm& form, const std::vector<std::vector<uint8_t>>& streams,
                  const std::vector<size_t>& counts) {
  Decoded decoded;
  for (size_t i = 0; i < streams.size(); ++i) {
    decoded.points.emplace_back(counts[i] * kNumbersPerPoint + kGuard, kUntouched);
  }
  for (size_t i = 0; i < streams.size(); ++i) {
    decoded.jobs.push_back({.stream = streams[i],
                            .points = static_cast<uint32_t>(counts[i]),
                            .out = decoded.points[i].data()});
  }
  ChunkDecoder decoder;
  decoder.Decode(form, decoded.jobs);
  return decoded;
}

bool Holds(const std::vector<uint16_t>& numbers, const DecodedIntegers& integers, size_t points) {
  for (size_t i = 0; i < points; ++i) {
    const uint16_t* n = &numbers[i * kNumbersPerPoint];
    const uint32_t* p = &integers.positions[3 * i];
    if (n[0] != p[0] || n[1] != p[1] || n[2] != p[2] || n[3] != 0) return false;
    const uint32_t s = integers.normals.empty() ? 0 : integers.normals[2 * i];
    const uint32_t t = integers.normals.empty() ? 0 : integers.normals[2 * i + 1];
    if (n[4] != s || n[5] != t) return false;
  }
  return true;
}

// Checks that the streams, decoded in one call, hold the chunks.
void ExpectHeld(const std::vector<Chunk>& chunks, const std::vector<std::vector<uint8_t>>& streams,
                const std::string& what) {
  std::vector<size_t> counts;
  for (const Chunk& chunk : chunks) counts.push_back(chunk.points);
  const Decoded decoded =
      DecodeAll({chunks[0].position_bits, chunks[0].normal_bits}, streams, counts);
  for (size_t i = 0; i < chunks.size(); ++i) {
    const ChunkJob& job = decoded.jobs[i];
    ASSERT_TRUE(job.decoded) << what << ", chunk " << i;
    ASSERT_TRUE(Holds(decoded.points[i], chunks[i].integers, counts[i])) << what << ", chunk " << i;
    for (size_t axis = 0; axis < 3; ++axis) {
      uint32_t low = ~0u, high = 0;
      for (size_t p = axis; p < 3 * counts[i]; p += 3) {
        low = std::min(low, chunks[i].integers.positions[p]);
        high = std::max(high, chunks[i].integers.positions[p]);
      }
      ASSERT_EQ(job.least[axis], low) << what << ", chunk " << i;
      ASSERT_EQ(job.most[axis], high) << what << ", chunk " << i;
    }
  }
}

std::vector<Chunk> ChunksOfAllKinds(int position_bits, int normal_bits) {
  constexpr size_t kPoints[] = {1, 2, 3, 66, 400, 2112};
  std::vector<Chunk> chunks;
  unsigned seed = 1;
  for (const Data data : kAllData) {
    for (const size_t points : kPoints) {
      chunks.push_back(MakeChunk(points, position_bits, normal_bits, data, seed++));
    }
  }
  return chunks;
}

TEST(ChunkDecoderTest, DecodesWhatTheWriterWrites) {
  const DracoWriter writer;
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : {0, 6, 7, 8, 9, 10, 11, 12}) {
      const std::vector<Chunk> chunks = ChunksOfAllKinds(position_bits, normal_bits);
      for (const bool sparse : {false, true}) {
        std::vector<std::vector<uint8_t>> streams(chunks.size());
        for (size_t i = 0; i < chunks.size(); ++i) {
          QuantisedVertices vertices = chunks[i].vertices();
          vertices.is_sparse = sparse;
          ASSERT_TRUE(writer.Encode({&vertices, 1}, 8.0, nullptr, {&streams[i], 1}).ok());
        }
        for (const int64_t target : latticed::testing::AllTargets()) {
          const latticed::testing::ChosenTarget chosen(target);
          ExpectHeld(chunks, streams,
                     fmt::format("{}, {} and {} bits, sparse: {}", lane_kernel::TargetName(),
                                 position_bits, normal_bits, sparse));
        }
      }
    }
  }
}

TEST(ChunkDecoderTest, DecodesMeshes) {
  constexpr size_t kPoints[] = {1, 3, 66, 2112, 65'535};
  const DracoWriter writer;
  for (const size_t points : kPoints) {
    const ChunkConnectivity connectivity(points, latticed::testing::Fan(points));
    std::vector<Chunk> chunks;
    std::vector<std::vector<uint8_t>> streams;
    for (unsigned seed = 1; seed <= 9; ++seed) {
      chunks.push_back(MakeChunk(points, 12, 8, Data::kWalk, seed));
      const QuantisedVertices vertices = chunks.back().vertices();
      ASSERT_TRUE(
          writer.Encode({&vertices, 1}, 8.0, &connectivity, {&streams.emplace_back(), 1}).ok());
    }
    ExpectHeld(chunks, streams, fmt::format("meshes of {} points", points));
  }
}

TEST(ChunkDecoderTest, RefusesAnotherForm) {
  const Chunk chunk = MakeChunk(66, 12, 8, Data::kWalk, 1);
  const QuantisedVertices vertices = chunk.vertices();
  std::vector<std::vector<uint8_t>> streams(1);
  ASSERT_TRUE(DracoWriter().Encode({&vertices, 1}, 8.0, nullptr, {streams.data(), 1}).ok());

  ASSERT_TRUE(DecodeAll({12, 8}, streams, {66}).jobs[0].decoded);
  EXPECT_FALSE(DecodeAll({12, 8}, streams, {65}).jobs[0].decoded);
  EXPECT_FALSE(DecodeAll({11, 8}, streams, {66}).jobs[0].decoded);
  EXPECT_FALSE(DecodeAll({12, 9}, streams, {66}).jobs[0].decoded);
  EXPECT_FALSE(DecodeAll({12, 0}, streams, {66}).jobs[0].decoded);
  for (const int bits : {-1, 0, 17, 33, 1 << 30}) {
    EXPECT_FALSE(DecodeAll({bits, 8}, streams, {66}).jobs[0].decoded) << bits;
  }
  for (const int bits : {-1, 13, 33, 1 << 30}) {
    EXPECT_FALSE(DecodeAll({12, bits}, streams, {66}).jobs[0].decoded) << bits;
  }
  EXPECT_FALSE(DecodeAll({12, 8}, streams, {0}).jobs[0].decoded);
  EXPECT_FALSE(DecodeAll({12, 8}, streams, {size_t{kMostPoints} + 1}).jobs[0].decoded);
  streams[0].push_back(0);
  EXPECT_FALSE(DecodeAll({12, 8}, streams, {66}).jobs[0].decoded);
}

TEST(ChunkDecoderTest, TenThousandUpdatesAllocateNothingAfterTheFirst) {
  std::vector<std::vector<uint8_t>> streams;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Chunk chunk = MakeChunk(66, 12, 8, kAllData[seed % std::size(kAllData)], seed);
    const QuantisedVertices vertices = chunk.vertices();
    ASSERT_TRUE(
        DracoWriter().Encode({&vertices, 1}, 8.0, nullptr, {&streams.emplace_back(), 1}).ok());
  }
  streams.back().resize(streams.back().size() / 2);  // is refused
  std::vector<uint16_t> points(streams.size() * 66 * kNumbersPerPoint);
  std::vector<ChunkJob> jobs;
  jobs.reserve(streams.size());
  for (const auto& stream : streams) {
    jobs.push_back({.stream = stream,
                    .points = 66,
                    .out = points.data() + jobs.size() * 66 * kNumbersPerPoint});
  }
  ChunkDecoder decoder;
  decoder.Decode({12, 8}, jobs);
  const latticed::testing::PeakMemory memory;

  for (int update = 0; update < 10'000; ++update) decoder.Decode({12, 8}, jobs);

  EXPECT_EQ(memory.peak(), 0u);
  EXPECT_TRUE(jobs[0].decoded);
  EXPECT_FALSE(jobs.back().decoded);
}

// Whatever is accepted has libdraco's values, and nothing is written beside the slice.
TEST(ChunkDecoderTest, DamagedStreamsAreRefusedOrDecodedAsLibdracoDoes) {
  const unsigned seed = std::random_device{}();
  std::cout << "seed " << seed << "\n";
  std::mt19937 random(seed);
  const DracoWriter writer;
  size_t accepted = 0;
  for (int round = 0; round < 2000; ++round) {
    const int normal_bits = round % 3 == 0 ? 0 : 8;
    const Data data = kAllData[random() % std::size(kAllData)];
    const size_t points = 1 + random() % 200;
    const Chunk chunk = MakeChunk(points, 12, normal_bits, data, static_cast<unsigned>(round));
    QuantisedVertices vertices = chunk.vertices();
    vertices.is_sparse = round % 2 == 0;
    std::vector<std::vector<uint8_t>> streams(5);
    for (auto& stream : streams) {
      ASSERT_TRUE(writer.Encode({&vertices, 1}, 8.0, nullptr, {&stream, 1}).ok());
      for (int flip = 0; flip <= round % 3; ++flip) {
        stream[random() % stream.size()] ^= static_cast<uint8_t>(1u << random() % 8);
      }
      if (random() % 8 == 0) stream.resize(random() % stream.size());
    }
    const Decoded decoded =
        DecodeAll({12, normal_bits}, streams, std::vector<size_t>(streams.size(), points));
    for (size_t i = 0; i < streams.size(); ++i) {
      for (size_t g = 0; g < kGuard; ++g) {
        ASSERT_EQ(decoded.points[i][points * kNumbersPerPoint + g], kUntouched);
      }
      if (!decoded.jobs[i].decoded) continue;
      ++accepted;
      const auto stock = DecodeDracoChunkIntegers(streams[i]);
      ASSERT_TRUE(stock.ok()) << round << ": " << stock.status();
      ASSERT_TRUE(Holds(decoded.points[i], *stock, points)) << round;
    }
  }
  std::cout << accepted << " of 10000 accepted\n";
}

}  // namespace
}  // namespace latticed::decoder
