// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vector code of the Draco writer, compiled once per instruction set. All sets give the same
// numbers: integers throughout, and the one float division is exact.
//
// Threads  pure functions on their arguments
#ifndef LATTICED_CORE_CODEC_DRACO_KERNEL_H_
#define LATTICED_CORE_CODEC_DRACO_KERNEL_H_

#include <cstddef>
#include <cstdint>

namespace latticed::draco_kernel {

// Streams that are coded side by side.
inline constexpr size_t kLanes = 16;
// Values of 32 bits that may be touched past the last one asked for.
inline constexpr size_t kPadding = 16;

struct ValueSpan {
  uint16_t least, most;
};
ValueSpan SpanOf(const uint16_t* values, size_t count);

// The symbols of draco_symbols.h, for `count` values of one component.
void PositionSymbols(const uint16_t* values, size_t count, ValueSpan span, uint16_t* symbols);
// The same for normals. A value takes one byte if it has up to 8 bits, else two.
void NormalSymbols(const uint8_t* s, const uint8_t* t, size_t count, int bits, uint16_t* s_symbols,
                   uint16_t* t_symbols);

// Adds up the `histograms`, which lie `stride` apart, and sets them to zero. Writes the symbols that occur, ascending,
// with their counts, and returns how many they are. All arrays have room for kPadding more than `size`.
size_t CollectCounts(uint32_t* histograms, size_t histogram_count, size_t stride, size_t size,
                     uint32_t* symbols, uint32_t* counts);

// One attribute of kLanes chunks. The symbols of lane l begin symbols_at[l] bytes after `symbols`, with a plane for
// each component. Its table is entries[entries_at[l] + symbol]: the probability in the low half of a word, the
// cumulative in the high half. Its bytes go to out + l * out_stride, with room for four more.
struct LaneStreams {
  const uint16_t* symbols;
  int32_t symbols_at[kLanes];
  size_t plane_stride;  // even, more than points
  const uint32_t* entries;
  int32_t entries_at[kLanes];
  uint8_t* out;
  size_t out_stride;
  uint32_t precision[kLanes];  // kMostLanePrecision at most
  // Results.
  uint32_t state[kLanes];
  uint32_t bytes[kLanes];
};
// Up to this precision the float quotient x / p, cut off, equals the quotient of the integers: x < 1024 p <= 2^23 is
// exact, and a quotient just below an integer k is rounded to less than k, since k p <= x + p < 2^24.
inline constexpr int kMostLanePrecision = 13;

// Whether CodeLanes can be used: it needs vectors of eight lanes or more.
bool HasLanes();
// Puts the symbols of all `points` into the lanes' states, last point first, like RansEncoder.
// `normals` may be null.
void CodeLanes(size_t points, LaneStreams& positions, LaneStreams* normals);

// Name of the instruction set that dispatch chose.
const char* TargetName();

}  // namespace latticed::draco_kernel

#endif  // LATTICED_CORE_CODEC_DRACO_KERNEL_H_
