// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks for tests of encoders: vertices in the QUANTISED layout, and the integers that their
// stream must hold.
#ifndef LATTICED_TESTS_CORE_CODEC_CHUNK_FIXTURES_H_
#define LATTICED_TESTS_CORE_CODEC_CHUNK_FIXTURES_H_

#include <array>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "core/codec/chunk_encoder.h"
#include "core/codec/draco_decode.h"
#include "core/codec/octahedral.h"

namespace latticed::testing {

enum class Data { kRandom, kConstant, kExtreme, kRamp, kWalk, kEven, kJumps };
inline constexpr Data kAllData[] = {Data::kRandom, Data::kConstant, Data::kExtreme, Data::kRamp,
                                    Data::kWalk,   Data::kEven,     Data::kJumps};

struct Chunk {
  size_t points = 0;
  int position_bits = 0, normal_bits = 0;
  std::vector<uint8_t> bytes;  // QUANTISED layout
  DecodedIntegers integers;    // what the stream must hold

  QuantisedVertices vertices() const {
    return QuantisedVertices::FromBytes(bytes, points, position_bits, normal_bits);
  }
};

// The value after `last`, in 0 … top.
inline uint32_t NextValue(Data data, size_t i, uint32_t last, uint32_t top, std::mt19937& random) {
  switch (data) {
    case Data::kRandom:
      return static_cast<uint32_t>(random()) % (top + 1);
    case Data::kConstant:
      return top / 3;
    case Data::kExtreme:
      return i % 2 == 0 ? 0 : top;
    case Data::kRamp:
      return static_cast<uint32_t>(i) % (top + 1);
    case Data::kWalk:  // small steps, and now and then a jump as between patches
      return i % 66 == 0 ? static_cast<uint32_t>(random()) % (top + 1)
                         : (last + static_cast<uint32_t>(random()) % 7) % (top + 1);
    case Data::kEven:  // 64 step sizes, all equally often
      return (last + 1 + static_cast<uint32_t>(i) % 64) % (top + 1);
    case Data::kJumps:  // mostly the same value, otherwise any
      return i % 8 == 0 ? static_cast<uint32_t>(random()) % (top + 1) : last;
  }
  return 0;
}

// With normal_bits = 0 there are no normals.
inline Chunk MakeChunk(size_t points, int position_bits, int normal_bits, Data data,
                       unsigned seed) {
  std::mt19937 random(seed);
  Chunk chunk{.points = points, .position_bits = position_bits, .normal_bits = normal_bits};
  const size_t width = normal_bits == 0 ? 0 : normal_bits <= 8 ? 1 : 2;
  chunk.bytes.resize((6 + 2 * width) * points);
  chunk.integers.positions.resize(3 * points);
  for (size_t axis = 0; axis < 3; ++axis) {
    uint32_t value = 0;
    for (size_t i = 0; i < points; ++i) {
      value = NextValue(data, i + axis, value, (1u << position_bits) - 1, random);
      std::memcpy(&chunk.bytes[2 * (axis * points + i)], &value, 2);
      chunk.integers.positions[3 * i + axis] = value;
    }
  }
  uint32_t s = 0, t = 0;
  for (size_t i = 0; width > 0 && i < points; ++i) {
    const auto top = static_cast<uint32_t>(OctahedralMax(normal_bits));
    s = NextValue(data, i, s, top, random), t = NextValue(data, i + 1, t, top, random);
    const OctahedralNormal n =
        CanonicaliseOctahedral({static_cast<int32_t>(s), static_cast<int32_t>(t)}, normal_bits);
    std::memcpy(&chunk.bytes[6 * points + width * i], &n.s, width);
    std::memcpy(&chunk.bytes[(6 + width) * points + width * i], &n.t, width);
    chunk.integers.normals.push_back(static_cast<uint32_t>(n.s));
    chunk.integers.normals.push_back(static_cast<uint32_t>(n.t));
  }
  return chunk;
}

// The triangles of a fan around the first point.
inline std::vector<std::array<uint32_t, 3>> Fan(size_t points) {
  std::vector<std::array<uint32_t, 3>> fan;
  for (uint32_t i = 2; i < points; ++i) fan.push_back({0, i - 1, i});
  return fan;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_CODEC_CHUNK_FIXTURES_H_
