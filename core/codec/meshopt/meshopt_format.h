// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The form of ENCODING_MESHOPT: meshoptimizer's vertex codec, version 1 (KHR_meshopt_compression, appendix A, mode 0), of
// vertices of 12 bytes.
//
//   vertex   x y z 0 s t, uint16 each, little endian; s and t are 0 without normals
//   stream   kHeader | blocks of 256 vertices, the last one of those that are left | 9 zeros, the first vertex, kModes
//   block    2 bits for each byte of a vertex, which say how that byte is coded | these bytes of all vertices
//
// A byte of a vertex is coded as its difference from the vertex before, zigzag, so that small differences are small
// numbers. Both bytes of a number share one difference of 16 bits; but s and t of up to 8 normal bits have differences
// of 8 bits, and no upper byte. Differences are divided into groups of 16. Those of the last group past the last vertex
// are 0. A group of `bits` holds differences below 2^bits - 1; larger ones are all ones there, and follow the group in
// full.
//
//   how a byte is coded   groups of
//   kFewBits              0, 1, 2, 4 bits: two bits for each group say which, before the groups
//   kManyBits             1, 2, 4, 8 bits: likewise
//   kZeros                nothing, since all differences are 0
//   kPlain                all differences as they are, without a last group's padding
//
// Of these the writers take the shortest. Of equal ones, kPlain before kFewBits before kManyBits, and fewer bits before more.
#ifndef LATTICED_CORE_CODEC_MESHOPT_MESHOPT_FORMAT_H_
#define LATTICED_CORE_CODEC_MESHOPT_MESHOPT_FORMAT_H_

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"

namespace latticed::meshopt_format {

inline constexpr uint8_t kHeader = 0xa1;
inline constexpr uint32_t kVertexBytes = 12, kChannelBytes = 4;
inline constexpr uint32_t kChannels = kVertexBytes / kChannelBytes;
inline constexpr uint32_t kBlockVertices = 256, kGroupVertices = 16;
inline constexpr uint32_t kBlockGroups = kBlockVertices / kGroupVertices;

enum Control : uint8_t { kFewBits = 0, kManyBits = 1, kZeros = 2, kPlain = 3 };
// The bits of a group, by control and by the two bits of the group.
inline constexpr uint8_t kGroupBits[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};

// Modes of a channel: differences of 8 or of 16 bits.
inline constexpr uint8_t kByteDifferences = 0, kShortDifferences = 1;
LATTICED_HD constexpr uint8_t NormalDifferences(int normal_bits) {
  return normal_bits > 8 ? kShortDifferences : kByteDifferences;
}
inline constexpr uint32_t kTailPadding = 9;
inline constexpr uint32_t kTailBytes = kTailPadding + kVertexBytes + kChannels;

LATTICED_HD constexpr uint32_t Groups(uint32_t vertices) {
  return (vertices + kGroupVertices - 1) / kGroupVertices;
}
// The bytes that tell the bits of so many groups.
LATTICED_HD constexpr uint32_t GroupHeaderBytes(uint32_t groups) { return (groups + 3) / 4; }

// Of a stream. No byte of a vertex takes more than kPlain.
constexpr size_t MostBytes(size_t vertices) {
  const size_t blocks = (vertices + kBlockVertices - 1) / kBlockVertices;
  return 1 + blocks * kChannels + vertices * kVertexBytes + kTailBytes;
}

}  // namespace latticed::meshopt_format

#endif  // LATTICED_CORE_CODEC_MESHOPT_MESHOPT_FORMAT_H_
