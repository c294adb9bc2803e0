// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertices of a view whose chunks have different numbers of points: each chunk has memory of its own, in the layout of
// core/view/vertex_layout.h.
//
// Threads  different chunks may be written at once
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_CHUNK_VERTICES_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_CHUNK_VERTICES_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/backend.h"

namespace latticed {

class ChunkVertices {
 public:
  ChunkVertices(size_t chunks, size_t bytes_per_point)
      : bytes_per_point_(bytes_per_point), chunks_(chunks) {}

  // Makes room for a chunk of so many points. Keeps the memory unless it is too little, or more than twice as much.
  std::span<uint8_t> Resize(size_t chunk, size_t points) {
    std::vector<uint8_t>& bytes = chunks_[chunk];
    const size_t size = points * bytes_per_point_;
    if (bytes.capacity() > 2 * size || bytes.capacity() < size) bytes = std::vector<uint8_t>(size);
    bytes.resize(size);
    return bytes;
  }
  std::span<const uint8_t> operator[](size_t chunk) const { return chunks_[chunk]; }
  size_t Points(size_t chunk) const { return chunks_[chunk].size() / bytes_per_point_; }

  size_t MemoryBytes() const {
    size_t bytes = chunks_.size() * sizeof(std::vector<uint8_t>);
    for (const auto& chunk : chunks_) bytes += chunk.capacity();
    return bytes;
  }

 private:
  const size_t bytes_per_point_;
  std::vector<std::vector<uint8_t>> chunks_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_CHUNK_VERTICES_H_
