// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Fuzzes the Draco writer: libdraco must decode the integers that were written, and a chunk must have
// the same bytes alone and in a batch.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "core/codec/draco_writer.h"
#include "core/codec/octahedral.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/holds_integers.h"

namespace latticed {
namespace {

constexpr size_t kBatch = 7;  // chunks; enough for the writer's vector code

void Require(bool holds) {
  if (!holds) std::abort();
}

// Makes each point from ten bytes of `data`: two bytes per coordinate of position and normal, reduced
// to their ranges.
std::vector<uint8_t> MakePlanes(const uint8_t* data, size_t points, int position_bits,
                                int normal_bits) {
  const size_t width = normal_bits == 0 ? 0 : normal_bits <= 8 ? 1 : 2;
  std::vector<uint8_t> planes((6 + 2 * width) * points);
  for (size_t i = 0; i < points; ++i) {
    std::array<uint16_t, 5> values;
    std::memcpy(values.data(), data + 10 * i, sizeof(values));
    for (size_t c = 0; c < 3; ++c) {
      values[c] = static_cast<uint16_t>(values[c] & ((1 << position_bits) - 1));
      std::memcpy(&planes[2 * (c * points + i)], &values[c], 2);
    }
    if (width == 0) continue;
    const int32_t count = OctahedralMax(normal_bits) + 1;
    const OctahedralNormal n =
        CanonicaliseOctahedral({values[3] % count, values[4] % count}, normal_bits);
    std::memcpy(&planes[6 * points + width * i], &n.s, width);
    std::memcpy(&planes[(6 + width) * points + width * i], &n.t, width);
  }
  return planes;
}

}  // namespace
}  // namespace latticed

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using latticed::QuantisedVertices;
  constexpr size_t kHead = 2, kPointBytes = 10;
  if (size < kHead + kPointBytes) return 0;
  const int position_bits = 8 + data[0] % 9;
  const int normal_bits = data[1] % 8 == 0 ? 0 : 5 + data[1] % 8;
  const size_t points = (size - kHead) / kPointBytes;
  const std::vector<uint8_t> planes =
      latticed::MakePlanes(data + kHead, points, position_bits, normal_bits);
  const QuantisedVertices vertices =
      QuantisedVertices::FromBytes(planes, points, position_bits, normal_bits);

  const std::vector<QuantisedVertices> chunks(latticed::kBatch, vertices);
  std::vector<std::vector<uint8_t>> streams(chunks.size());
  const latticed::DracoWriter writer;
  latticed::Require(writer.Encode(chunks, 8.0, nullptr, streams).ok());
  const auto alone = latticed::testing::EncodePoints(writer, vertices, 8.0);
  latticed::Require(alone.ok());
  for (const auto& stream : streams) latticed::Require(stream == *alone);
  latticed::Require(latticed::testing::HoldsIntegers(*alone, vertices));
  return 0;
}
