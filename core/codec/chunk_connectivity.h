// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The triangles of a chunk, and their code in Draco's method MESH_SEQUENTIAL: the bytes from the
// number of faces to the last index. They are made once for all chunks of a shape.
//
//   varint faces | varint points | 0 | symbols of the indices' differences, coded as by rans_table.h
//
// Threads  immutable
#ifndef LATTICED_CORE_CODEC_CHUNK_CONNECTIVITY_H_
#define LATTICED_CORE_CODEC_CHUNK_CONNECTIVITY_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace latticed {

class ChunkConnectivity {
 public:
  // Indices below point_count.
  ChunkConnectivity(size_t point_count, std::span<const std::array<uint32_t, 3>> triangles);

  std::span<const std::array<uint32_t, 3>> triangles() const { return triangles_; }
  std::span<const uint8_t> bytes() const { return bytes_; }
  // The least size of a whole stream. libdraco does not read what is behind the attributes, so zeros fill it.
  size_t LeastStreamBytes() const;
  size_t MemoryBytes() const;

 private:
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<uint8_t> bytes_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_CHUNK_CONNECTIVITY_H_
