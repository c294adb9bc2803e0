// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/codec/meshopt/meshopt_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include <algorithm>
#include <bit>
#include <cstring>

#include "core/codec/meshopt/byte_groups-inl.h"
#include "core/codec/meshopt/meshopt_kernel.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::meshopt_kernel {
namespace HWY_NAMESPACE {

using meshopt_format::Control;
using meshopt_format::GroupHeaderBytes;
using meshopt_format::Groups;
using meshopt_format::kBlockGroups;
using meshopt_format::kBlockVertices;
using meshopt_format::kChannels;
using meshopt_format::kFewBits;
using meshopt_format::kGroupBits;
using meshopt_format::kGroupVertices;
using meshopt_format::kManyBits;
using meshopt_format::kPlain;
using meshopt_format::kZeros;

// The differences of one byte of a block's vertices.
struct alignas(16) ByteDifferences {
  uint8_t bytes[kBlockVertices];
};

// The zigzag differences of a block's numbers, from the one before the first on. `T`: how many bits they have.
template <class T>
HWY_INLINE void Differences(const uint16_t* numbers, ByteDifferences& lower,
                            ByteDifferences& upper) {
  using Signed = std::make_signed_t<T>;
  for (uint32_t i = 0; i < kBlockVertices; ++i) {
    const auto difference = static_cast<Signed>(numbers[i + 1] - numbers[i]);
    const auto zigzag = static_cast<T>(2 * difference ^ difference >> (8 * sizeof(T) - 1));
    lower.bytes[i] = static_cast<uint8_t>(zigzag);
    upper.bytes[i] = static_cast<uint8_t>(zigzag >> 8);
  }
}

// How a byte of a block is coded.
struct Choice {
  Control control;
  uint8_t groups[kBlockGroups];  // of kFewBits and kManyBits: places in kGroupBits
};

HWY_INLINE Choice Choose(const ByteDifferences& differences, uint32_t count) {
  const uint32_t groups = Groups(count);
  alignas(16) uint8_t few[kBlockGroups], many[kBlockGroups];
  uint32_t few_bytes = GroupHeaderBytes(groups), many_bytes = few_bytes, any = 0;
  for (uint32_t g = 0; g < groups; ++g) {
    const TooLarge large = FindTooLarge(differences.bytes + g * kGroupVertices);
    any |= large.of_1;
    const int bytes_1 = 2 + std::popcount(large.of_1), bytes_2 = 4 + std::popcount(large.of_2),
              bytes_4 = 8 + std::popcount(large.of_4);
    const int least = std::min({bytes_1, bytes_2, bytes_4});
    const int place = bytes_1 == least ? 0 : bytes_2 == least ? 1 : 2;
    few[g] = static_cast<uint8_t>(large.of_1 == 0 ? 0 : place + 1);
    few_bytes += static_cast<uint32_t>(large.of_1 == 0 ? 0 : least);
    many[g] = static_cast<uint8_t>(least <= 16 ? place : 3);
    many_bytes += static_cast<uint32_t>(std::min(least, 16));
  }
  Choice choice{.control = kZeros, .groups = {}};
  if (any == 0) return choice;
  if (count <= few_bytes && count <= many_bytes) {
    choice.control = kPlain;
    return choice;
  }
  choice.control = few_bytes <= many_bytes ? kFewBits : kManyBits;
  std::memcpy(choice.groups, choice.control == kFewBits ? few : many, groups);
  return choice;
}

HWY_INLINE uint8_t* PutByte(const ByteDifferences& differences, uint32_t count, Control& control,
                            uint8_t* out) {
  const Choice choice = Choose(differences, count);
  control = choice.control;
  if (choice.control == kZeros) return out;
  if (choice.control == kPlain) {
    std::memcpy(out, differences.bytes, count);
    return out + count;
  }
  const uint32_t groups = Groups(count);
  for (uint32_t g = 0; g < groups; g += 4) {  // places past the last group are 0
    *out++ = static_cast<uint8_t>(choice.groups[g] | choice.groups[g + 1] << 2 |
                                  choice.groups[g + 2] << 4 | choice.groups[g + 3] << 6);
  }
  for (uint32_t g = 0; g < groups; ++g) {
    out = PutGroup(differences.bytes + g * kGroupVertices,
                   kGroupBits[choice.control][choice.groups[g]], out);
  }
  return out;
}

// The numbers of one component of a chunk.
struct Component {
  const uint8_t* numbers;  // null: all are 0
  uint32_t width;          // bytes of a number
};

// A block's numbers, behind the one before them; that before the first of all is the first itself. Those past the last
// repeat it.
HWY_INLINE void ReadBlock(const Component& component, size_t first, uint32_t count,
                          uint16_t (&numbers)[kBlockVertices + 1]) {
  if (component.width == 1) {
    const uint8_t* from = component.numbers + first;
    for (uint32_t i = 0; i < count; ++i) numbers[i + 1] = from[i];
  } else {
    std::memcpy(numbers + 1, component.numbers + first * sizeof(uint16_t),
                count * sizeof(uint16_t));
  }
  if (first == 0) numbers[0] = numbers[1];
  std::fill(numbers + 1 + count, std::end(numbers), numbers[count]);
}

uint8_t* WriteBlocksImpl(const QuantisedVertices& chunk, uint8_t* out) {
  const uint32_t normal_width = chunk.normal_bits <= 8 ? 1 : 2;
  const auto positions = [](const uint16_t* numbers) {
    return Component{reinterpret_cast<const uint8_t*>(numbers), sizeof(uint16_t)};
  };
  // As they lie in a vertex.
  const Component components[] = {positions(chunk.x),      positions(chunk.y),
                                  positions(chunk.z),      {nullptr, 0},
                                  {chunk.s, normal_width}, {chunk.t, normal_width}};
  constexpr size_t kComponents = std::size(components);
  uint16_t numbers[kComponents][kBlockVertices + 1];
  ByteDifferences lower, upper;
  for (size_t first = 0; first < chunk.point_count; first += kBlockVertices) {
    const auto count =
        static_cast<uint32_t>(std::min<size_t>(kBlockVertices, chunk.point_count - first));
    uint8_t* const controls = out;
    out = std::fill_n(out, kChannels, uint8_t{0});
    const auto put = [&](size_t byte, const ByteDifferences& differences) {
      Control control;
      out = PutByte(differences, count, control, out);
      controls[byte / 4] |= static_cast<uint8_t>(control << (byte % 4 * 2));
    };
    for (size_t c = 0; c < kComponents; ++c) {
      if (components[c].numbers == nullptr) {
        controls[c / 2] |= static_cast<uint8_t>((kZeros | kZeros << 2) << (c % 2 * 4));
        continue;
      }
      ReadBlock(components[c], first, count, numbers[c]);
      if (components[c].width == 1) {
        Differences<uint8_t>(numbers[c], lower, upper);
      } else {
        Differences<uint16_t>(numbers[c], lower, upper);
      }
      put(2 * c, lower);
      put(2 * c + 1, upper);
      numbers[c][0] = numbers[c][kBlockVertices];
    }
  }
  return out;
}

const char* TargetNameImpl() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace latticed::meshopt_kernel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::meshopt_kernel {

HWY_EXPORT(WriteBlocksImpl);
HWY_EXPORT(TargetNameImpl);

uint8_t* WriteBlocks(const QuantisedVertices& chunk, uint8_t* out) {
  return HWY_DYNAMIC_DISPATCH(WriteBlocksImpl)(chunk, out);
}
const char* TargetName() { return HWY_DYNAMIC_DISPATCH(TargetNameImpl)(); }

}  // namespace latticed::meshopt_kernel
#endif  // HWY_ONCE
