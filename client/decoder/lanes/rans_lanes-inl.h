// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// States of up to eight streams in turns: while one waits for its table, the others go on. A word has the state x < 2^22
// at its top and the stream's next bytes below it, so that to take bytes in is a shift:
//
//   x' = x - cumulative - q complement, then a byte for each 8 bits that x' lacks of 2^14
//
// x' >= 4, since q >= 4: two bytes a symbol at most. 42 bits below the state are enough for two symbols.
// Included once per instruction set by lane_kernel.cc.
#if defined(LATTICED_CLIENT_DECODER_LANES_RANS_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CLIENT_DECODER_LANES_RANS_LANES_INL_H_
#undef LATTICED_CLIENT_DECODER_LANES_RANS_LANES_INL_H_
#else
#define LATTICED_CLIENT_DECODER_LANES_RANS_LANES_INL_H_
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "client/decoder/lanes/lane_kernel.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
// Every machine that Highway gives AVX2 has it, but Highway 1.0 does not tell the compiler.
#if HWY_TARGET <= HWY_AVX2
HWY_PUSH_ATTRIBUTES("lzcnt")
#endif
namespace latticed::decoder::lane_kernel {
namespace HWY_NAMESPACE {

constexpr int kQuotientShift = kStateShift + kNarrowPrecision;
constexpr int kBelowState = 64 - kStateShift;
constexpr uint64_t kLeastState = uint64_t{4} << kNarrowPrecision;
constexpr uint32_t kMostSymbolBytes = 2;

// Takes the next symbol. Returns the bits that were shifted in.
HWY_INLINE uint32_t Step(uint64_t& word, const NarrowTable& table, uint16_t* out) {
  const uint32_t rank = table.rank[word >> kStateShift & (kNarrowSlots - 1)];
  word -= table.cumulative[rank] + (word >> kQuotientShift) * table.complement[rank];
  *out = table.symbol[rank];
  const auto bits = static_cast<uint32_t>(__builtin_clzll(word)) & 24;  // never of 0, since x' >= 4
  word <<= bits;
  return bits;
}

// Decodes as many symbols as all lanes surely have bytes for. The tables and columns of a whole group lie side by side, so
// one address of each is enough, and registers are left for the words. Each lane takes one symbol before any takes a second:
// a processor's queue then holds work of more lanes.
template <size_t kCount>
HWY_INLINE void RunTogether(SymbolLane* const* lanes) {
  constexpr bool kWhole = kCount == kLanes;
  uint32_t steps = ~0u;
  std::array<uint64_t, kCount> word;
  std::array<const uint8_t*, kCount> at;
  std::array<uint16_t*, kCount> out;
  std::array<const NarrowTable*, kCount> table;
  for (size_t k = 0; k < kCount; ++k) {
    const SymbolLane& lane = *lanes[k];
    const auto bytes = static_cast<size_t>(lane.at - lane.begin);
    steps = static_cast<uint32_t>(
        std::min<size_t>({steps, lane.symbols - lane.done, bytes / kMostSymbolBytes}));
    word[k] = lane.word;
    at[k] = lane.at;
    table[k] = lane.table;
    out[k] = lane.out + size_t{lane.done} * kLanes;
  }
  steps &= ~1u;
  const auto table_of = [&](size_t k) { return kWhole ? table[0] + k : table[k]; };
  const auto out_of = [&](size_t k) { return kWhole ? out[0] + k : out[k]; };
  for (uint32_t step = 0; step < steps; step += 2) {
    std::array<uint32_t, kCount> bits;
    for (size_t k = 0; k < kCount; ++k) {
      uint64_t below;
      std::memcpy(&below, at[k] - sizeof(below), sizeof(below));
      // Bytes that are there already are put to the same place.
      word[k] |= below >> kBelowState;
      bits[k] = Step(word[k], *table_of(k), out_of(k));
    }
    for (size_t k = 0; k < kCount; ++k) {
      at[k] -= (bits[k] + Step(word[k], *table_of(k), out_of(k) + kLanes)) / 8;
    }
    for (size_t k = 0; k < (kWhole ? 1 : kCount); ++k) out[k] += 2 * kLanes;
  }
  for (size_t k = 0; k < kCount; ++k) {
    lanes[k]->word = word[k];
    lanes[k]->at = at[k];
    lanes[k]->done += steps;
  }
}

// Decodes the last symbols byte by byte, and checks the end.
inline void RunToEnd(SymbolLane& lane) {
  uint64_t state = lane.word >> kStateShift;
  for (; lane.done < lane.symbols; ++lane.done) {
    const NarrowTable& table = *lane.table;
    const uint32_t rank = table.rank[state & (kNarrowSlots - 1)];
    state -= (table.cumulative[rank] >> kStateShift) +
             (state >> kNarrowPrecision) * (table.complement[rank] >> kStateShift);
    lane.out[size_t{lane.done} * kLanes] = table.symbol[rank];
    while (state < kLeastState && lane.at != lane.begin) state = state << 8 | *--lane.at;
    if (state < kLeastState) break;
  }
  const bool ended = lane.done == lane.symbols && state == kLeastState && lane.at == lane.begin;
  if (!ended) lane.table = nullptr;
}

void DecodeSymbolsImpl(SymbolLane* lanes, size_t count) {
  std::array<SymbolLane*, kLanes> running{};
  for (size_t k = 0; k < count; ++k) running[k] = lanes + k;
  while (count > 0) {
    const size_t together = std::bit_floor(count);
    if (together == 8) RunTogether<8>(running.data());
    if (together == 4) RunTogether<4>(running.data());
    if (together == 2) RunTogether<2>(running.data());
    if (together == 1) RunTogether<1>(running.data());
    for (size_t k = together; k-- > 0;) {
      SymbolLane& lane = *running[k];
      const auto bytes = static_cast<size_t>(lane.at - lane.begin);
      if (lane.symbols - lane.done >= 2 && bytes >= 2 * kMostSymbolBytes) continue;
      RunToEnd(lane);
      running[k] = running[--count];
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::decoder::lane_kernel
#if HWY_TARGET <= HWY_AVX2
HWY_POP_ATTRIBUTES
#endif
HWY_AFTER_NAMESPACE();

#endif
