// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/decoder/meshopt/meshopt_kernel.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include <algorithm>
#include <cstring>

#include "client/decoder/meshopt/byte_groups-inl.h"
#include "client/decoder/meshopt/meshopt_kernel.h"
#include "client/decoder/meshopt/vertices-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::decoder::meshopt_kernel {
namespace HWY_NAMESPACE {

using meshopt_format::GroupHeaderBytes;
using meshopt_format::Groups;
using meshopt_format::kBlockVertices;
using meshopt_format::kChannels;
using meshopt_format::kGroupBits;
using meshopt_format::kGroupVertices;
using meshopt_format::kPlain;
using meshopt_format::kVertexBytes;
using meshopt_format::kZeros;

// Reads the differences of one byte of a block's vertices. Returns the end of their code, null where it is too long.
HWY_INLINE const uint8_t* ReadByte(const uint8_t* at, const uint8_t* end, unsigned control,
                                   uint32_t count, uint8_t* differences) {
  if (control == kZeros) {
    std::memset(differences, 0, kBlockVertices);
    return at;
  }
  const auto left = static_cast<size_t>(end - at);
  if (control == kPlain) {
    if (count > left) return nullptr;
    std::memcpy(differences, at, count);
    return at + count;
  }
  const uint32_t groups = Groups(count);
  const uint8_t* const header = at;
  if (GroupHeaderBytes(groups) > left) return nullptr;
  at += GroupHeaderBytes(groups);
  for (uint32_t g = 0; g < groups; ++g) {
    const unsigned place = header[g / 4] >> (g % 4 * 2) & 3;
    at = ReadGroup(at, kGroupBits[control][place], differences + g * kGroupVertices);
    if (at > end) return nullptr;
  }
  return at;
}

bool ReadBlocksImpl(Blocks& blocks) {
  BlockDifferences differences;
  std::memset(&differences, 0, sizeof(differences));
  VertexSum sum(blocks);
  const uint8_t* at = blocks.begin;
  for (uint32_t first = 0; first < blocks.vertices; first += kBlockVertices) {
    const uint32_t count = std::min(kBlockVertices, blocks.vertices - first);
    if (static_cast<size_t>(blocks.end - at) < kChannels) return false;
    const uint8_t* const controls = at;
    at += kChannels;
    for (uint32_t byte = 0; byte < kVertexBytes; ++byte) {
      const unsigned control = controls[byte / 4] >> (byte % 4 * 2) & 3;
      if ((blocks.bytes >> byte & 1) == 0) {
        if (control != kZeros) return false;
        continue;
      }
      at = ReadByte(at, blocks.end, control, count, differences.bytes[byte]);
      if (at == nullptr) return false;
    }
    sum.Write(differences, count, blocks.out + size_t{first} * kNumbers,
              first + count == blocks.vertices);
  }
  sum.Finish(blocks);
  return at == blocks.end;
}

const char* TargetNameImpl() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace latticed::decoder::meshopt_kernel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::decoder::meshopt_kernel {

HWY_EXPORT(ReadBlocksImpl);
HWY_EXPORT(TargetNameImpl);

bool ReadBlocks(Blocks& blocks) { return HWY_DYNAMIC_DISPATCH(ReadBlocksImpl)(blocks); }
const char* TargetName() { return HWY_DYNAMIC_DISPATCH(TargetNameImpl)(); }

}  // namespace latticed::decoder::meshopt_kernel
#endif  // HWY_ONCE
