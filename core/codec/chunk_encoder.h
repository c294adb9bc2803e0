// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Encodes the quantised vertices of chunks as Draco streams. A stock decoder reads each stream by itself.
//
// A stream holds POSITION (float32, quantised: origin 0, range = the quantisation box's range, so
// decoded positions are relative to the box's origin) and, with normals, NORMAL (octahedral);
// points in wire order; Draco 2.3 point cloud sequential, or 2.2 mesh sequential with triangles.
//
// Errors   kInternal when the library refuses (never on legal input)
// Threads  Encode… is const and may be called from any number of threads
#ifndef LATTICED_CORE_CODEC_CHUNK_ENCODER_H_
#define LATTICED_CORE_CODEC_CHUNK_ENCODER_H_

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace latticed {

class ChunkConnectivity;

// Planar view of a chunk in the QUANTISED layout (see core/backend.h, VertexFormat::kQuantised).
struct QuantisedVertices {
  size_t point_count = 0;
  int position_bits = 12;
  int normal_bits = 0;  // 0: no normals
  // Whether neighbours are far apart. Our writer then tries the scheme TAGGED too, and takes the shorter one.
  bool is_sparse = false;
  const uint16_t* x = nullptr;
  const uint16_t* y = nullptr;
  const uint16_t* z = nullptr;
  // One byte a value for normal_bits <= 8, else two, little endian.
  const uint8_t* s = nullptr;
  const uint8_t* t = nullptr;

  bool SameShape(const QuantisedVertices& other) const {
    return point_count == other.point_count && position_bits == other.position_bits &&
           normal_bits == other.normal_bits;
  }

  // Points into `bytes`, which must hold point_count points.
  static QuantisedVertices FromBytes(std::span<const uint8_t> bytes, size_t point_count,
                                     int position_bits, int normal_bits);
};

class ChunkEncoder {
 public:
  virtual ~ChunkEncoder() = default;
  virtual std::string_view name() const = 0;  // "reference", "latticed"
  // The number of chunks in one call that is fastest.
  virtual size_t batch() const = 0;

  // The most working memory that one call takes for chunks of `points` points. It is kept for the
  // next call, so there are as many blocks as concurrent calls. 0: none is kept.
  virtual uint64_t WorkingBytes(size_t /*points*/, int /*position_bits*/,
                                int /*normal_bits*/) const {
    return 0;
  }

  // Makes streams[i] from chunks[i], each of which has at least one point. With `connectivity` the
  // streams are meshes, and all chunks have as many points as it has. It may be null.
  [[nodiscard]] virtual absl::Status Encode(std::span<const QuantisedVertices> chunks, double range,
                                            const ChunkConnectivity* connectivity,
                                            std::span<std::vector<uint8_t>> streams) const = 0;
};

// libdraco (core/codec/draco_reference.cc).
[[nodiscard]] std::unique_ptr<ChunkEncoder> MakeReferenceEncoder();
// "reference" or "latticed" (core/codec/draco_writer.h); null for another name.
[[nodiscard]] std::unique_ptr<ChunkEncoder> MakeChunkEncoder(std::string_view name);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_CHUNK_ENCODER_H_
