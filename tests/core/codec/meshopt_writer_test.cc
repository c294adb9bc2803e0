// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The meshopt writer: literal streams, the same bytes under each instruction set, the largest stream. That stock decoders
// read the streams is tested in draco3d/compare_streams.mjs.
#include "core/codec/meshopt/meshopt_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/codec/meshopt/meshopt_format.h"
#include "core/codec/meshopt/meshopt_kernel.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/instruction_sets.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAreArray;
using ::testing::Le;
using ::testing::SizeIs;

TEST(MeshoptWriterTest, OnePointIsItsOwnBaseline) {
  const uint16_t x = 0x0102, y = 0x0304, z = 0x0506;
  const uint8_t s = 7, t = 8;
  const QuantisedVertices chunk{.point_count = 1,
                                .position_bits = 12,
                                .normal_bits = 8,
                                .x = &x,
                                .y = &y,
                                .z = &z,
                                .s = &s,
                                .t = &t};
  const uint8_t expected[] = {
      0xa1,                                         // the codec's version
      0xaa, 0xaa, 0xaa,                             // all twelve bytes: zeros
      0,    0,    0,    0, 0, 0, 0, 0, 0,           // padding
      2,    1,    4,    3, 6, 5, 0, 0, 7, 0, 8, 0,  // the point
      1,    1,    0,                                // differences of 16, 16 and 8 bits
  };
  EXPECT_THAT(EncodeMeshopt(chunk), ElementsAreArray(expected));
}

TEST(MeshoptWriterTest, SmallDifferencesTakeFewBits) {
  // x: 0 1 0 1 …, so its zigzag differences are 0 2 1 2 1 …; y: one jump by 300; z: constant.
  std::vector<uint16_t> x(32), y(32), z(32, 9);
  for (size_t i = 0; i < 32; ++i) x[i] = i % 2, y[i] = i < 20 ? 0 : 300;
  const QuantisedVertices chunk{
      .point_count = 32, .position_bits = 12, .x = x.data(), .y = y.data(), .z = z.data()};
  const uint8_t expected[] = {
      0xa1,
      // x: few bits, zeros. y: few bits in both bytes. All others: zeros.
      0x08,
      0xaa,
      0xaa,
      // The lower byte of x: two groups of 2 bits, four differences a byte, the first in the highest bits.
      0x0a,
      0x26,
      0x66,
      0x66,
      0x66,
      0x66,
      0x66,
      0x66,
      0x66,
      // Of y, 600 = 0x0258: no bits, then 1 bit with a mark at the fifth difference, and its value.
      0x04,
      0x10,
      0x00,
      0x58,
      0x04,
      0x10,
      0x00,
      0x02,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      9,
      0,
      0,
      0,
      0,
      0,
      0,
      0,
      1,
      1,
      0,
  };
  EXPECT_THAT(EncodeMeshopt(chunk), ElementsAreArray(expected));
}

TEST(MeshoptWriterTest, BytesDoNotDependOnTheInstructionSet) {
  unsigned seed = 1;
  for (const size_t points : {1u, 15u, 16u, 17u, 66u, 255u, 256u, 257u, 2112u, 5000u}) {
    for (const auto& [position_bits, normal_bits] :
         {std::pair(8, 6), {12, 0}, {12, 8}, {14, 9}, {16, 12}}) {
      for (const Data data : kAllData) {
        const Chunk chunk = MakeChunk(points, position_bits, normal_bits, data, seed++);
        std::vector<uint8_t> expected;
        for (const int64_t target : AllTargets()) {
          const ChosenTarget chosen(target);
          const std::vector<uint8_t> stream = EncodeMeshopt(chunk.vertices());
          if (expected.empty()) expected = stream;
          EXPECT_EQ(stream, expected)
              << meshopt_kernel::TargetName() << ", " << points << " points, seed " << seed - 1;
        }
        EXPECT_THAT(expected, SizeIs(Le(meshopt_format::MostBytes(points))));
      }
    }
  }
}

// Of 16-bit noise nothing can be saved.
TEST(MeshoptWriterTest, NoiseTakesItsOwnBytes) {
  const Chunk chunk = MakeChunk(512, 16, 12, Data::kRandom, 5);
  // Two blocks of three control bytes. Plain: the bytes of three positions and the lower bytes of normals of 12 bits.
  const size_t least = 1 + 2 * (3 + 256 * 8) + meshopt_format::kTailBytes;
  const size_t bytes = EncodeMeshopt(chunk.vertices()).size();
  EXPECT_GE(bytes, least);
  EXPECT_LE(bytes, least + 2 * 2 * 256);
}

}  // namespace
}  // namespace latticed::testing
