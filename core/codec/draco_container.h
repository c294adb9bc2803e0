// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bytes of a chunk's Draco stream that are not symbols. All but a few numbers are constant.
//
//   "DRACO" major minor geometry method flags16      2.3 point cloud, 2.2 mesh; method sequential
//   points: int32                                    a mesh has its connectivity here instead
//   1 decoder; attributes; type, data type, components, normalised, id of each; coder of each
//   then each attribute:
//     prediction method, transform
//     1 scheme coder | table | length | states       or 0 width | plain symbols
//     bounds of the transform: int32, int32
//   then each attribute's dequantisation: float min[3] float range bits, or bits
//
// Source   Draco bitstream specification, google.github.io/draco/spec
// Threads  pure functions
#ifndef LATTICED_CORE_CODEC_DRACO_CONTAINER_H_
#define LATTICED_CORE_CODEC_DRACO_CONTAINER_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/codec/byte_writer.h"

namespace latticed {

enum class DracoAttribute { kPosition, kNormal };

// Numbers of the format.
namespace draco_format {
inline constexpr uint32_t kMajor = 2, kCloudMinor = 3, kMeshMinor = 2;
inline constexpr uint32_t kCloud = 0, kMesh = 1, kSequential = 0, kCompressedIndices = 0;
inline constexpr uint32_t kPositionType = 0, kNormalType = 1, kFloat32 = 9;
inline constexpr uint32_t kQuantisedCoder = 2, kOctahedralCoder = 3;
inline constexpr uint32_t kDifference = 0, kWrap = 1, kCanonicalOctahedron = 3;
inline constexpr uint32_t kPlain = 0, kCoded = 1;  // whether symbols are coded
}  // namespace draco_format

// The bytes from "DRACO" to flags.
inline constexpr size_t kDracoHeaderBytes = 11;
// All that is neither connectivity nor symbols, rounded up.
inline constexpr size_t kMostContainerBytes = 128;
// libdraco refuses a mesh with less than three bytes a face after its counts, however well the indices are coded.
constexpr size_t LeastMeshBytes(size_t faces) {
  return kDracoHeaderBytes + 2 * kMostVarintBytes + 3 * faces;
}

// Writes what comes before the attributes. normal_bits = 0: no normals.
void WriteCloudHead(size_t point_count, int normal_bits, ByteWriter& out);
// `connectivity`: the bytes of a ChunkConnectivity.
void WriteMeshHead(std::span<const uint8_t> connectivity, int normal_bits, ByteWriter& out);

// Writes what comes before the symbols of an attribute.
void WritePrediction(DracoAttribute attribute, ByteWriter& out);
// Write what comes after the symbols.
void WritePositionBounds(uint32_t least, uint32_t most, ByteWriter& out);
void WriteNormalBounds(int normal_bits, ByteWriter& out);

// Writes the end of the stream: decoded position = integer * range / (2^position_bits - 1).
void WriteDequantisation(int position_bits, int normal_bits, float range, ByteWriter& out);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_CONTAINER_H_
