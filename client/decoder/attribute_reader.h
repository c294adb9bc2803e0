// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads one attribute of a chunk: its symbols in all codings that latticed writes.
#ifndef LATTICED_CLIENT_DECODER_ATTRIBUTE_READER_H_
#define LATTICED_CLIENT_DECODER_ATTRIBUTE_READER_H_

#include <cstdint>

#include "client/decoder/byte_reader.h"
#include "client/decoder/lanes/lane_kernel.h"
#include "client/decoder/symbol_table.h"

namespace latticed::decoder {

// Reads the symbols of `points` points. Most are left to the kernel, in `lane`, whose `out` must be set; lane->table is null
// where they are decoded already. Sets the largest symbol that may occur. False for anything that latticed does not write.
[[nodiscard]] bool ReadSymbols(ByteReader& in, uint32_t components, uint32_t points,
                               NarrowTable* narrow, WideTable* wide, lane_kernel::SymbolLane* lane,
                               uint32_t* largest);

// Changes the symbols of positions that wrap at `span` values, in a column of rows, to such that wrap at 2^16.
void Unwrap(uint16_t* column, uint32_t points, uint32_t span);

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_ATTRIBUTE_READER_H_
