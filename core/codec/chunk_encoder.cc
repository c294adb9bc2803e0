// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/chunk_encoder.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/codec/chunk_connectivity.h"
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

absl::StatusOr<std::vector<uint8_t>> ChunkEncoder::EncodePoints(const QuantisedVertices& vertices,
                                                                double range) const {
  std::vector<uint8_t> stream;
  LATTICED_RETURN_IF_ERROR(Encode({&vertices, 1}, range, nullptr, {&stream, 1}));
  return stream;
}

absl::StatusOr<std::vector<uint8_t>> ChunkEncoder::EncodeMesh(
    const QuantisedVertices& vertices, double range,
    std::span<const std::array<uint32_t, 3>> triangles) const {
  const ChunkConnectivity connectivity(vertices.point_count, triangles);
  std::vector<uint8_t> stream;
  LATTICED_RETURN_IF_ERROR(Encode({&vertices, 1}, range, &connectivity, {&stream, 1}));
  return stream;
}

std::unique_ptr<ChunkEncoder> MakeChunkEncoder(std::string_view name) {
  if (name == kDracoWriterName) return std::make_unique<DracoWriter>();
  if (name == "reference") return MakeReferenceEncoder();
  return nullptr;
}

}  // namespace latticed
