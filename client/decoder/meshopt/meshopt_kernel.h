// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vector code that decodes meshopt streams (core/codec/meshopt/meshopt_format.h), compiled once per instruction set.
//
// Threads  pure
#ifndef LATTICED_CLIENT_DECODER_MESHOPT_MESHOPT_KERNEL_H_
#define LATTICED_CLIENT_DECODER_MESHOPT_MESHOPT_KERNEL_H_

#include <cstdint>

namespace latticed::decoder::meshopt_kernel {

inline constexpr uint32_t kNumbers = 6;  // of a vertex

// The blocks of a stream, and what is known of their vertices.
struct Blocks {
  const uint8_t* begin;
  const uint8_t* end;  // kTailBytes may be read from here on
  uint32_t vertices;
  uint16_t before[kNumbers];  // from which the first vertex differs
  // Bytes of a vertex that may differ, a bit each, the first the lowest. Others must be coded as zeros.
  uint32_t bytes;
  bool byte_differences;  // of s and t
  uint16_t* out;          // vertices x kNumbers

  // Results.
  uint16_t least[kNumbers], most[kNumbers];
};

// Returns whether the blocks are as they must be, up to their end.
bool ReadBlocks(Blocks& blocks);

const char* TargetName();

}  // namespace latticed::decoder::meshopt_kernel

#endif  // LATTICED_CLIENT_DECODER_MESHOPT_MESHOPT_KERNEL_H_
