// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Draco through libdraco: reads uploads in the DRACO format, and chunks on the client's side; writes the DRC export.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, for bytes that are no Draco stream
// Threads  pure functions
#ifndef LATTICED_CORE_CODEC_DRACO_DECODE_H_
#define LATTICED_CORE_CODEC_DRACO_DECODE_H_

#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

class ReadingMemory;  // core/mesh/reading_memory.h

// A mesh stream (any method) as a polygon mesh of triangles: positions, normals, first UV set.
// `memory` grants what the announced counts need with positions, normals and UVs; null grants everything. Further
// attributes, which libdraco decodes too, are not asked for.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadDracoMesh(std::string_view bytes,
                                                        ReadingMemory* memory = nullptr);
// Writes a mesh as one Draco stream, the DRC export: sequential, in the order of MakeVertexRecords, with faces divided
// into triangles. Positions have 16 bits and normals 12 unless told otherwise, uvs as many as positions but at least 12.
[[nodiscard]] absl::StatusOr<std::string> WriteDracoMesh(const PolygonMesh& mesh,
                                                         int position_bits = 16,
                                                         int normal_bits = 12);

struct DecodedChunk {
  std::vector<float> positions;  // 3 per point, relative to the quantisation box's origin
  std::vector<float> normals;    // 3 per point, or empty
};
// One chunk stream, points in stream order.
[[nodiscard]] absl::StatusOr<DecodedChunk> DecodeDracoChunk(std::span<const uint8_t> bytes);

struct DecodedIntegers {
  std::vector<uint32_t> positions;  // 3 per point
  std::vector<uint32_t> normals;    // s, t per point, or empty
};
// The same without the attribute transforms: the integers that the stream holds.
[[nodiscard]] absl::StatusOr<DecodedIntegers> DecodeDracoChunkIntegers(
    std::span<const uint8_t> bytes);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_DECODE_H_
