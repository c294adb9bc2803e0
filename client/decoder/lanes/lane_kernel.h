// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The part of decoding that takes the time, compiled once per instruction set. All sets give the same integers.
//
// Rows     symbols lie in rows of kLanes, one number a chunk: the row of point i, component c is c + components * i
// Threads  pure functions on their arguments
#ifndef LATTICED_CLIENT_DECODER_LANES_LANE_KERNEL_H_
#define LATTICED_CLIENT_DECODER_LANES_LANE_KERNEL_H_

#include <cstddef>
#include <cstdint>

#include "client/decoder/lanes/narrow_table.h"

namespace latticed::decoder::lane_kernel {

// Chunks that are decoded side by side.
inline constexpr size_t kLanes = 8;
// A wrapped sum of 16 bits tells less than the least from more than the most up to this many values, 2^16 / 2.5.
inline constexpr uint32_t kMostLaneSpan = 26'214;

// The symbols of one attribute of one chunk, while they are decoded.
struct SymbolLane {
  uint64_t word = 0;  // the state, and bytes of the stream below it
  const uint8_t* at =
      nullptr;  // the byte before this is the next below the state; 8 bytes before `begin` may be read
  const uint8_t* begin = nullptr;  // of the coded bytes
  const NarrowTable* table = nullptr;
  uint16_t* out = nullptr;  // the lane's place in the first row
  uint32_t symbols = 0;
  uint32_t done = 0;
};

// Decodes all symbols of `count` lanes. If these are kLanes, their tables are an array, their columns lie side by side, and
// nothing is done yet. Sets table to null in those whose bytes do not end where they began.
void DecodeSymbols(SymbolLane* lanes, size_t count);

// What turns rows into points.
struct PointLanes {
  const uint16_t* position_rows = nullptr;
  const uint16_t* normal_rows = nullptr;  // null: no normals
  int normal_bits = 0;
  // Of positions: the least value, and how many there are, 0 for 2^16.
  uint16_t least[kLanes] = {}, span[kLanes] = {};
  uint32_t points[kLanes] = {};  // descending; 0: no chunk
  uint16_t* out[kLanes] = {};    // kNumbersPerPoint each
  // Results, of x y z.
  uint16_t low[3][kLanes] = {}, high[3][kLanes] = {};
};
void WritePoints(PointLanes& lanes);

// Name of the instruction set that dispatch chose.
const char* TargetName();

}  // namespace latticed::decoder::lane_kernel

#endif  // LATTICED_CLIENT_DECODER_LANES_LANE_KERNEL_H_
