// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The reference writer: libdraco. Normals go in as the unit vectors at the centres of their cells,
// which libdraco rounds back to the same integers (proven for every cell in octahedral_test.cc).
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/status_macros.h"
#include "core/codec/chunk_connectivity.h"
#include "core/codec/chunk_encoder.h"
#include "core/codec/draco_geometry.h"
#include "core/codec/octahedral.h"

namespace latticed {
namespace {

int32_t NormalValue(const uint8_t* plane, size_t point, int bits) {
  if (bits <= 8) return plane[point];
  uint16_t value = 0;
  std::memcpy(&value, plane + 2 * point, sizeof(value));
  return value;
}

DracoGeometry ToGeometry(const QuantisedVertices& vertices, double range) {
  DracoGeometry geometry{.point_count = vertices.point_count,
                         .position_bits = vertices.position_bits,
                         .normal_bits = vertices.normal_bits,
                         .range = static_cast<float>(range)};
  geometry.grid_positions.resize(3 * vertices.point_count);
  for (size_t i = 0; i < vertices.point_count; ++i) {
    geometry.grid_positions[3 * i + 0] = static_cast<float>(vertices.x[i]);
    geometry.grid_positions[3 * i + 1] = static_cast<float>(vertices.y[i]);
    geometry.grid_positions[3 * i + 2] = static_cast<float>(vertices.z[i]);
  }
  if (vertices.normal_bits == 0) return geometry;
  const int bits = vertices.normal_bits;
  geometry.normals.resize(3 * vertices.point_count);
  for (size_t i = 0; i < vertices.point_count; ++i) {
    const Vec3f n = DequantiseNormal(
        {NormalValue(vertices.s, i, bits), NormalValue(vertices.t, i, bits)}, bits);
    geometry.normals[3 * i + 0] = n.x;
    geometry.normals[3 * i + 1] = n.y;
    geometry.normals[3 * i + 2] = n.z;
  }
  return geometry;
}

class ReferenceEncoder final : public ChunkEncoder {
 public:
  std::string_view name() const override { return "reference"; }

  size_t batch() const override { return 1; }

  absl::Status Encode(std::span<const QuantisedVertices> chunks, double range,
                      const ChunkConnectivity* connectivity,
                      std::span<std::vector<uint8_t>> streams) const override {
    std::optional<TriangleSpan> triangles;
    if (connectivity != nullptr) triangles = connectivity->triangles();
    for (size_t i = 0; i < chunks.size(); ++i) {
      LATTICED_ASSIGN_OR_RETURN(auto stream, EncodeDraco(ToGeometry(chunks[i], range), triangles));
      streams[i] = std::move(stream);
    }
    return absl::OkStatus();
  }
};

}  // namespace

std::unique_ptr<ChunkEncoder> MakeReferenceEncoder() {
  return std::make_unique<ReferenceEncoder>();
}

}  // namespace latticed
