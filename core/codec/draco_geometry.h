// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// libdraco's encoder with an exact quantisation of positions.
//
// libdraco passes explicit quantisation through text with six decimals, and chooses the encoder of
// an attribute by its data type, so it needs floats. Positions therefore go in as *grid
// units* (origin 0, range 2^bits - 1: every integer is its own float), and the 17 bytes of the
// transform that decoders read, float min[3], float range, uint8 bits, are written afterwards. All
// transforms are at the end of a sequential stream, in attribute order:
//
//   … | POSITION min[3] range bits | NORMAL bits | TEX_COORD min[2] range bits |
//
// Errors   kInternal when libdraco refuses, or when the transform is not where it should be
// Threads  pure function
#ifndef LATTICED_CORE_CODEC_DRACO_GEOMETRY_H_
#define LATTICED_CORE_CODEC_DRACO_GEOMETRY_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"

namespace latticed {

struct DracoGeometry {
  size_t point_count = 0;
  int position_bits = 16;
  int normal_bits = 0;                // 0: no normals
  int uv_bits = 0;                    // 0: no uvs
  std::vector<float> grid_positions;  // 3 per point, integers in 0 … 2^position_bits - 1
  std::vector<float> normals;         // 3 per point
  std::vector<float> uvs;             // 2 per point
  std::array<float, 3> origin{};      // decoded position = origin + integer * range / (2^bits - 1)
  float range = 1;
};

using TriangleSpan = std::span<const std::array<uint32_t, 3>>;

// Without triangles a point cloud, else a mesh; sequential, so points and triangles keep their
// order.
[[nodiscard]] absl::StatusOr<std::vector<uint8_t>> EncodeDraco(
    const DracoGeometry& geometry, std::optional<TriangleSpan> triangles);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_GEOMETRY_H_
