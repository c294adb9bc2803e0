// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vector code of the meshopt writer, compiled once per instruction set. All sets write the same bytes.
//
// Threads  pure
#ifndef LATTICED_CORE_CODEC_MESHOPT_MESHOPT_KERNEL_H_
#define LATTICED_CORE_CODEC_MESHOPT_MESHOPT_KERNEL_H_

#include <cstddef>
#include <cstdint>

#include "core/codec/chunk_encoder.h"

namespace latticed::meshopt_kernel {

// Bytes that may be touched past the last one written.
inline constexpr size_t kPadding = 32;

// Writes all blocks of a chunk, and returns their end.
uint8_t* WriteBlocks(const QuantisedVertices& chunk, uint8_t* out);

// Name of the instruction set that dispatch chose.
const char* TargetName();

}  // namespace latticed::meshopt_kernel

#endif  // LATTICED_CORE_CODEC_MESHOPT_MESHOPT_KERNEL_H_
