// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/decoder/meshopt/meshopt_reader.h"

#include <algorithm>
#include <cstring>

#include "client/decoder/meshopt/meshopt_kernel.h"
#include "core/codec/meshopt/meshopt_format.h"
#include "core/codec/octahedral.h"

namespace latticed::decoder {
namespace {

using meshopt_format::kByteDifferences;
using meshopt_format::kHeader;
using meshopt_format::kShortDifferences;
using meshopt_format::kTailBytes;
using meshopt_format::kTailPadding;
using meshopt_format::kVertexBytes;
using meshopt_format::NormalDifferences;
using meshopt_kernel::Blocks;
using meshopt_kernel::kNumbers;

constexpr uint32_t kPositionBytes = 0x03f;  // of a vertex, a bit each

uint32_t BytesThatDiffer(int normal_bits) {
  constexpr uint32_t kNormalBytes = 0xf00, kNormalLowerBytes = 0x500;
  if (normal_bits == 0) return kPositionBytes;
  return kPositionBytes | (normal_bits > 8 ? kNormalBytes : kNormalLowerBytes);
}

// Reads the end of a stream.
bool ReadTail(const uint8_t* tail, int normal_bits, Blocks& blocks) {
  if (std::any_of(tail, tail + kTailPadding, [](uint8_t byte) { return byte != 0; })) return false;
  std::memcpy(blocks.before, tail + kTailPadding, kVertexBytes);
  if (blocks.byte_differences && (blocks.before[4] | blocks.before[5]) > 0xff) return false;
  const uint8_t* const modes = tail + kTailPadding + kVertexBytes;
  return modes[0] == kShortDifferences && modes[1] == kShortDifferences &&
         modes[2] == NormalDifferences(normal_bits);
}

bool IsWithin(const ChunkForm& form, const Blocks& blocks) {
  const uint32_t position = (1u << form.position_bits) - 1;
  const auto normal =
      form.normal_bits == 0 ? 0u : static_cast<uint32_t>(OctahedralMax(form.normal_bits));
  const uint32_t largest[kNumbers] = {position, position, position, 0, normal, normal};
  for (uint32_t i = 0; i < kNumbers; ++i) {
    if (blocks.most[i] > largest[i]) return false;
  }
  return true;
}

}  // namespace

void DecodeMeshopt(const ChunkForm& form, ChunkJob& job) {
  const std::span<const uint8_t> stream = job.stream;
  if (stream.size() < 1 + kTailBytes || stream[0] != kHeader) return;
  const uint8_t* const tail = stream.data() + stream.size() - kTailBytes;
  Blocks blocks{.begin = stream.data() + 1,
                .end = tail,
                .vertices = job.points,
                .before = {},
                .bytes = BytesThatDiffer(form.normal_bits),
                .byte_differences = NormalDifferences(form.normal_bits) == kByteDifferences,
                .out = job.out,
                .least = {},
                .most = {}};
  if (!ReadTail(tail, form.normal_bits, blocks) || !meshopt_kernel::ReadBlocks(blocks)) return;
  if (!IsWithin(form, blocks)) return;
  std::copy_n(blocks.least, 3, job.least);
  std::copy_n(blocks.most, 3, job.most);
  job.decoded = true;
}

}  // namespace latticed::decoder
