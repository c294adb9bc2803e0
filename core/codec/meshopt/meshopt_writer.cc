// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/meshopt/meshopt_writer.h"

#include <algorithm>
#include <cstring>

#include "core/codec/meshopt/meshopt_format.h"
#include "core/codec/meshopt/meshopt_kernel.h"

namespace latticed {
namespace {

using meshopt_format::kShortDifferences;
using meshopt_format::kTailPadding;
using meshopt_format::kVertexBytes;
using meshopt_format::NormalDifferences;

uint16_t NormalNumber(const uint8_t* numbers, int normal_bits) {
  if (normal_bits <= 8) return numbers[0];
  uint16_t number;
  std::memcpy(&number, numbers, sizeof(number));
  return number;
}

uint8_t* WriteTail(const QuantisedVertices& chunk, uint8_t* out) {
  out = std::fill_n(out, kTailPadding, uint8_t{0});
  uint16_t first[kVertexBytes / sizeof(uint16_t)] = {chunk.x[0], chunk.y[0], chunk.z[0], 0, 0, 0};
  if (chunk.normal_bits > 0) {
    first[4] = NormalNumber(chunk.s, chunk.normal_bits);
    first[5] = NormalNumber(chunk.t, chunk.normal_bits);
  }
  std::memcpy(out, first, sizeof(first));
  out += sizeof(first);
  for (const uint8_t mode :
       {kShortDifferences, kShortDifferences, NormalDifferences(chunk.normal_bits)}) {
    *out++ = mode;
  }
  return out;
}

}  // namespace

std::vector<uint8_t> EncodeMeshopt(const QuantisedVertices& chunk) {
  // Kept for the next call. Fresh pages for every chunk would take a third of the time.
  thread_local std::vector<uint8_t> room;
  const size_t most = meshopt_format::MostBytes(chunk.point_count) + meshopt_kernel::kPadding;
  if (room.size() < most) room.resize(most);
  uint8_t* out = room.data();
  *out++ = meshopt_format::kHeader;
  out = meshopt_kernel::WriteBlocks(chunk, out);
  out = WriteTail(chunk, out);
  return {room.data(), out};
}

}  // namespace latticed
