// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/chunk_encoder.h"

#include "core/codec/draco_writer.h"

namespace latticed {

QuantisedVertices QuantisedVertices::FromBytes(std::span<const uint8_t> bytes, size_t point_count,
                                               int position_bits, int normal_bits) {
  const size_t position_bytes = point_count * sizeof(uint16_t);
  const auto position = [&](size_t plane) {
    return reinterpret_cast<const uint16_t*>(bytes.data() + plane * position_bytes);
  };
  QuantisedVertices vertices{.point_count = point_count,
                             .position_bits = position_bits,
                             .normal_bits = normal_bits,
                             .x = position(0),
                             .y = position(1),
                             .z = position(2)};
  if (normal_bits > 0) {
    vertices.s = bytes.data() + 3 * position_bytes;
    vertices.t = vertices.s + point_count * (normal_bits <= 8 ? 1 : 2);
  }
  return vertices;
}

std::unique_ptr<ChunkEncoder> MakeChunkEncoder(std::string_view name) {
  if (name == kDracoWriterName) return std::make_unique<DracoWriter>();
  if (name == "reference") return MakeReferenceEncoder();
  return nullptr;
}

}  // namespace latticed
