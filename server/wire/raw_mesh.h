// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MESH_FORMAT_RAW: arrays without gaps, little endian, in the order of v1.RawLayout's comment.
//
//   positions  vertex_count x 3 float32 or float64
//   sizes      face_count uint32               where face_size is 0
//   corners    corner_count uint32
//   normals    (vertices or corners) x 3 float32
//   uvs        (vertices or corners) x 2 float32
//   groups     face_count uint32               where there are group_names
//   weights    vertex_count float32            where the layout has weights
//
// Errors   kInvalidArgument with the path of the field, or MALFORMED_FILE with the byte
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_RAW_MESH_H_
#define LATTICED_SERVER_WIRE_RAW_MESH_H_

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/reading_memory.h"
#include "latticed/v1/mesh.pb.h"

namespace latticed {

// Counts within limits, known enums, and arrays that fill `total_bytes` exactly.
[[nodiscard]] absl::Status CheckRawLayout(const v1::RawLayout& layout, uint64_t total_bytes);
// `layout` has been checked against bytes.size(). The result is valid.
// `memory` grants what the layout needs; null grants everything.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadRawMesh(const v1::RawLayout& layout,
                                                      std::string_view bytes,
                                                      ReadingMemory* memory = nullptr);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_RAW_MESH_H_
