// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes groups of sixteen differences of a byte. 24 bytes may be read from where a group begins: no group is longer.
// Included once per instruction set by meshopt_kernel.cc.
#if defined(LATTICED_CLIENT_DECODER_MESHOPT_BYTE_GROUPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CLIENT_DECODER_MESHOPT_BYTE_GROUPS_INL_H_
#undef LATTICED_CLIENT_DECODER_MESHOPT_BYTE_GROUPS_INL_H_
#else
#define LATTICED_CLIENT_DECODER_MESHOPT_BYTE_GROUPS_INL_H_
#endif

#include <cstdint>
#include <cstring>

#include "core/codec/meshopt/meshopt_format.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::decoder::meshopt_kernel {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using meshopt_format::kGroupVertices;

#if HWY_TARGET == HWY_SCALAR

// The code of a group of `kBits`; returns its end.
template <int kBits>
HWY_INLINE const uint8_t* ReadPacked(const uint8_t* at, uint8_t* group) {
  constexpr uint32_t kInAByte = 8 / kBits;
  constexpr unsigned kLargest = (1u << kBits) - 1;
  const uint8_t* rest = at + kGroupVertices / kInAByte;
  for (uint32_t i = 0; i < kGroupVertices; ++i) {
    const uint32_t place = i % kInAByte;
    const unsigned shift = kBits * (kBits == 1 ? place : kInAByte - 1 - place);
    const unsigned value = at[i / kInAByte] >> shift & kLargest;
    group[i] = value == kLargest ? *rest++ : static_cast<uint8_t>(value);
  }
  return rest;
}

#else

using Group = hn::FixedTag<uint8_t, kGroupVertices>;
using Half = hn::FixedTag<uint8_t, 8>;

// Sixteen bytes: at the marked places those from `rest` on, in order, else 0. Moves `rest` behind the last one.
HWY_INLINE hn::Vec<Group> ReadMarked(hn::Mask<Group> is_marked, const uint8_t*& rest) {
  const Group d;
  // How many are marked up to each place, less one: where its byte is. The upper bit stands for none.
  auto place = hn::VecFromMask(d, is_marked);
  place = hn::Add(place, hn::ShiftLeftBytes<1>(d, place));
  place = hn::Add(place, hn::ShiftLeftBytes<2>(d, place));
  place = hn::Add(place, hn::ShiftLeftBytes<4>(d, place));
  place = hn::Not(hn::Add(place, hn::ShiftLeftBytes<8>(d, place)));
  const auto none = hn::AndNot(hn::VecFromMask(d, is_marked), hn::Set(d, uint8_t{0x80}));
  const auto bytes = hn::LoadU(d, rest);
  rest += hn::CountTrue(d, is_marked);
  return hn::TableLookupBytesOr0(bytes, hn::Or(place, none));
}

// Each byte of the code `kInAByte` times, then shifted so that each difference is in the lowest bits of one.
template <int kBits>
HWY_INLINE hn::Vec<Group> Unpack(const uint8_t* at) {
  const Group d;
  const hn::Repartition<uint16_t, Group> d16;
  if constexpr (kBits == 4) {
    const auto bytes = hn::LoadU(Half(), at);
    const auto first =
        hn::And(hn::ShiftRight<4>(hn::PromoteTo(d16, bytes)), hn::Set(d16, uint16_t{15}));
    const auto second =
        hn::ShiftLeft<8>(hn::And(hn::PromoteTo(d16, bytes), hn::Set(d16, uint16_t{15})));
    return hn::BitCast(d, hn::Or(first, second));
  } else {
    const hn::Repartition<uint32_t, Group> d32;
    const auto bytes = hn::PromoteTo(d32, hn::LoadU(hn::FixedTag<uint8_t, 4>(), at));
    const auto all = hn::Or(hn::Or(hn::ShiftRight<6>(bytes), hn::ShiftLeft<4>(bytes)),
                            hn::Or(hn::ShiftLeft<14>(bytes), hn::ShiftLeft<24>(bytes)));
    return hn::And(hn::BitCast(d, all), hn::Set(d, uint8_t{3}));
  }
}

template <int kBits>
HWY_INLINE const uint8_t* ReadPacked(const uint8_t* at, uint8_t* group) {
  const Group d;
  if constexpr (kBits == 1) {
    const auto is_marked = hn::LoadMaskBits(d, at);
    at += kGroupVertices / 8;
    hn::StoreU(ReadMarked(is_marked, at), d, group);
    return at;
  } else {
    const auto values = Unpack<kBits>(at);
    at += kGroupVertices * kBits / 8;
    const auto is_large = hn::Eq(values, hn::Set(d, uint8_t{(1 << kBits) - 1}));
    const auto large = ReadMarked(is_large, at);
    hn::StoreU(hn::IfThenElse(is_large, large, values), d, group);
    return at;
  }
}

#endif

HWY_INLINE const uint8_t* ReadGroup(const uint8_t* at, int bits, uint8_t* group) {
  switch (bits) {
    case 0:
      std::memset(group, 0, kGroupVertices);
      return at;
    case 1:
      return ReadPacked<1>(at, group);
    case 2:
      return ReadPacked<2>(at, group);
    case 4:
      return ReadPacked<4>(at, group);
    default:
      std::memcpy(group, at, kGroupVertices);
      return at + kGroupVertices;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::decoder::meshopt_kernel
HWY_AFTER_NAMESPACE();

#endif
