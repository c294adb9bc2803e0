// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Groups of sixteen differences of a byte: how large they are, and their code.
// Included once per instruction set by meshopt_kernel.cc.
#if defined(LATTICED_CORE_CODEC_MESHOPT_BYTE_GROUPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CODEC_MESHOPT_BYTE_GROUPS_INL_H_
#undef LATTICED_CORE_CODEC_MESHOPT_BYTE_GROUPS_INL_H_
#else
#define LATTICED_CORE_CODEC_MESHOPT_BYTE_GROUPS_INL_H_
#endif

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "core/codec/meshopt/meshopt_format.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::meshopt_kernel {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using meshopt_format::kGroupVertices;

// Which of sixteen differences do not fit: that are not below 2^bits - 1.
struct TooLarge {
  uint32_t of_1, of_2, of_4;  // by bits; a bit a difference, the first the lowest
};

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE TooLarge FindTooLarge(const uint8_t* group) {
  TooLarge found{};
  for (uint32_t i = 0; i < kGroupVertices; ++i) {
    found.of_1 |= uint32_t{group[i] >= 1} << i;
    found.of_2 |= uint32_t{group[i] >= 3} << i;
    found.of_4 |= uint32_t{group[i] >= 15} << i;
  }
  return found;
}

// Writes those whose bit is set, and returns their end.
HWY_INLINE uint8_t* PutMarked(const uint8_t* group, uint32_t marks, uint8_t* out) {
  for (; marks != 0; marks &= marks - 1) *out++ = group[std::countr_zero(marks)];
  return out;
}

// Packs differences, no larger than the largest of `kBits`, the first into the highest bits.
template <int kBits>
HWY_INLINE uint8_t* PutPacked(const uint8_t* group, uint8_t* out) {
  constexpr int kInAByte = 8 / kBits;
  constexpr uint8_t kLargest = (1 << kBits) - 1;
  for (uint32_t i = 0; i < kGroupVertices; i += kInAByte) {
    unsigned byte = 0;
    for (uint32_t k = 0; k < kInAByte; ++k) byte = byte << kBits | HWY_MIN(group[i + k], kLargest);
    *out++ = static_cast<uint8_t>(byte);
  }
  return out;
}

#else

using Group = hn::FixedTag<uint8_t, kGroupVertices>;

HWY_INLINE uint32_t BitsOf(hn::Mask<Group> mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(Group(), mask, bytes);
  uint16_t bits;
  std::memcpy(&bits, bytes, sizeof(bits));
  return bits;
}

HWY_INLINE TooLarge FindTooLarge(const uint8_t* group) {
  const Group d;
  const auto v = hn::LoadU(d, group), zero = hn::Zero(d);
  const auto fit = [&](uint8_t largest) {
    return BitsOf(hn::Eq(hn::SaturatedSub(v, hn::Set(d, largest)), zero));
  };
  constexpr uint32_t kAll = 0xffff;
  return {BitsOf(hn::Eq(v, zero)) ^ kAll, fit(2) ^ kAll, fit(14) ^ kAll};
}

// By marks of eight bytes, the places of those that are marked, one after the other.
inline constexpr auto kMarkedPlaces = [] {
  std::array<std::array<uint8_t, 8>, 256> places{};
  for (unsigned marks = 0; marks < places.size(); ++marks) {
    size_t found = 0;
    for (uint8_t i = 0; i < 8; ++i) {
      if ((marks >> i & 1) != 0) places[marks][found++] = i;
    }
  }
  return places;
}();

HWY_INLINE uint8_t* PutMarked(const uint8_t* group, uint32_t marks, uint8_t* out) {
  const hn::FixedTag<uint8_t, 8> half;
  for (size_t h = 0; h < 2; ++h, marks >>= 8) {
    const uint32_t its = marks & 0xff;
    const auto bytes = hn::LoadU(half, group + 8 * h);
    hn::StoreU(hn::TableLookupBytes(bytes, hn::LoadU(half, kMarkedPlaces[its].data())), half, out);
    out += std::popcount(its);
  }
  return out;
}

template <int kBits>
HWY_INLINE uint8_t* PutPacked(const uint8_t* group, uint8_t* out) {
  const Group d;
  const hn::Repartition<uint16_t, Group> d16;
  const hn::Repartition<uint32_t, Group> d32;
  const auto v = hn::Min(hn::LoadU(d, group), hn::Set(d, uint8_t{(1 << kBits) - 1}));
  if constexpr (kBits == 4) {
    const auto pairs = hn::BitCast(d16, v);
    const auto bytes = hn::BitCast(d, hn::Or(hn::ShiftLeft<4>(pairs), hn::ShiftRight<8>(pairs)));
    HWY_ALIGN static constexpr uint8_t kLower[16] = {0, 2, 4, 6, 8, 10, 12, 14};
    hn::StoreU(hn::TableLookupBytes(bytes, hn::Load(d, kLower)), d, out);
    return out + 8;
  } else {
    const auto fours = hn::BitCast(d32, v);
    const auto bytes = hn::Or(hn::Or(hn::ShiftLeft<30>(fours), hn::ShiftLeft<20>(fours)),
                              hn::Or(hn::ShiftLeft<10>(fours), fours));
    HWY_ALIGN static constexpr uint8_t kUpper[16] = {3, 7, 11, 15};
    hn::StoreU(hn::TableLookupBytes(hn::BitCast(d, bytes), hn::Load(d, kUpper)), d, out);
    return out + 4;
  }
}

#endif

// Writes a group of kGroupBits, and returns its end. Bytes past it may be touched.
HWY_INLINE uint8_t* PutGroup(const uint8_t* group, int bits, uint8_t* out) {
  const TooLarge large = FindTooLarge(group);
  switch (bits) {
    case 1:  // here the first is in the lowest bit
      out[0] = static_cast<uint8_t>(large.of_1);
      out[1] = static_cast<uint8_t>(large.of_1 >> 8);
      return PutMarked(group, large.of_1, out + 2);
    case 2:
      return PutMarked(group, large.of_2, PutPacked<2>(group, out));
    case 4:
      return PutMarked(group, large.of_4, PutPacked<4>(group, out));
    case 8:
      std::memcpy(out, group, kGroupVertices);
      return out + kGroupVertices;
    default:
      return out;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::meshopt_kernel
HWY_AFTER_NAMESPACE();

#endif
