// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads those parts of a chunk's stream that are not symbols (core/codec/draco_container.h has the layout).
//
// Errors   false, or a reader that is not ok(), for anything that latticed does not write
#ifndef LATTICED_CLIENT_DECODER_CHUNK_LAYOUT_H_
#define LATTICED_CLIENT_DECODER_CHUNK_LAYOUT_H_

#include <cstdint>
#include <vector>

#include "client/decoder/byte_reader.h"
#include "client/decoder/chunk_decoder.h"
#include "client/decoder/symbol_table.h"

namespace latticed::decoder {

// The connectivity that was read last. All meshes of one number of points have the same.
struct KnownConnectivity {
  std::vector<uint8_t> bytes;
  uint32_t points = 0, faces = 0;
};

struct ChunkHead {
  bool is_mesh = false;
  uint32_t faces = 0;
};

// Reads up to the first attribute.
[[nodiscard]] bool ReadHead(ByteReader& in, const ChunkForm& form, uint32_t points,
                            WideTable* table, KnownConnectivity* known, ChunkHead* head);
// Reads what follows the attributes, to the end.
[[nodiscard]] bool ReadTail(ByteReader& in, const ChunkForm& form, const ChunkHead& head,
                            uint64_t stream_bytes);

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_CHUNK_LAYOUT_H_
