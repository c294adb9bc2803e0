// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/writing_memory.h"

#include "core/base/vec.h"

namespace latticed {
namespace {

constexpr uint64_t kSmallBytes = 4'096;  // of any format: units, PLY's properties, GLB's empty JSON

// Binary values of a point.
uint64_t PointBytes(const WrittenSizes& sizes) {
  return sizeof(Vec3f) + (sizes.has_normals ? sizeof(Vec3f) : 0) +
         (sizes.has_uvs ? sizeof(Vec2f) : 0);
}

uint64_t MostGlbBytes(const WrittenSizes& sizes) {
  // A group's objects in JSON's tree, which are copied twice, and its text. Names are escaped, six bytes for one.
  constexpr uint64_t kBytesPerGroup = 8'192, kBytesPerNameByte = 32;
  const uint64_t order = sizes.groups > 0 ? sizeof(uint32_t) : 0;
  return sizes.points * PointBytes(sizes) + sizes.triangles * (3 * sizeof(uint32_t) + order) +
         (sizes.groups + 1) * kBytesPerGroup + sizes.name_bytes * kBytesPerNameByte;
}

// Measured: a stream beside libdraco's copies of attributes and faces, its integers and its symbols.
uint64_t MostDracoBytes(const WrittenSizes& sizes) {
  constexpr uint64_t kBytesPerPoint = 64, kBytesPerTriangle = 48, kTableBytes = uint64_t{1} << 20;
  return sizes.points * (kBytesPerPoint + 4 * PointBytes(sizes)) +
         sizes.triangles * kBytesPerTriangle + kTableBytes;
}

}  // namespace

uint64_t MostObjBytes(const WrittenSizes& sizes) {
  // "-2.2250738585072014e-308" and "-1.1754944e-38", each with the character before it.
  constexpr uint64_t kDoubleBytes = 25, kFloatBytes = 16, kLineBytes = 3;  // "vn", line end
  uint64_t digits = 1;
  for (uint64_t rest = sizes.points; rest >= 10; rest /= 10) ++digits;
  const uint64_t indices = 1u + (sizes.has_uvs ? 1u : 0u) + (sizes.has_normals ? 1u : 0u);
  constexpr uint64_t kSlashes = 2;
  return kSmallBytes +
         sizes.points * (3 * kDoubleBytes + kLineBytes +
                         (sizes.has_normals ? 3 * kFloatBytes + kLineBytes : 0) +
                         (sizes.has_uvs ? 2 * kFloatBytes + kLineBytes : 0)) +
         sizes.triangles * (3 * (1 + indices * digits + (indices > 1 ? kSlashes : 0)) + 2) +
         sizes.group_lines * sizeof("usemtl \n") + sizes.group_line_bytes;
}

uint64_t MostWritingBytes(MeshFormat format, const WrittenSizes& sizes) {
  switch (format) {
    case MeshFormat::kObj:
      return MostObjBytes(sizes);
    case MeshFormat::kPly:
      return kSmallBytes + sizes.points * PointBytes(sizes) +
             sizes.triangles * (1 + 3 * sizeof(uint32_t));
    case MeshFormat::kStl:
      return kSmallBytes + sizes.triangles * (4 * sizeof(Vec3f) + sizeof(uint16_t));
    case MeshFormat::kGlb:
      return MostGlbBytes(sizes);
    case MeshFormat::kDraco:
      return MostDracoBytes(sizes);
  }
  return 0;
}

}  // namespace latticed
