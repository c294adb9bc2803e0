// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/write/writing_memory.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/vec.h"
#include "core/mesh/write/glb_materials.h"

namespace latticed {
namespace {

constexpr uint64_t kSmallBytes = 4'096;  // of any format: units, PLY's properties, GLB's empty JSON
constexpr uint64_t kIndexBytes = sizeof(uint32_t);

// Binary values of a record.
uint64_t RecordBytes(const WrittenSizes& sizes) {
  return sizeof(Vec3f) + (sizes.normals > 0 ? sizeof(Vec3f) : 0) +
         (sizes.uvs > 0 ? sizeof(Vec2f) : 0);
}

// MakeVertexRecords: both ends of a list for each position; each record twice, with a link and a number. The first two
// grow by doubling, while the smaller half is copied.
uint64_t RecordTableBytes(const WrittenSizes& sizes) {
  constexpr uint64_t kRecordBytes = 3 * kIndexBytes, kGrowth = 2;
  return 2 * sizes.positions * kIndexBytes + sizes.corners * kIndexBytes +
         sizes.records * (kGrowth * (kRecordBytes + kIndexBytes) + kRecordBytes + kIndexBytes);
}

uint64_t MostGlbBytes(const WrittenSizes& sizes, std::string_view source) {
  // A group's objects in JSON's tree, which are copied twice, and its text. Names are escaped, six bytes for one.
  constexpr uint64_t kBytesPerGroup = 8'192, kBytesPerNameByte = 32;
  const uint64_t order = sizes.groups > 0 ? sizes.faces * kIndexBytes : 0;
  return sizes.records * RecordBytes(sizes) + sizes.corners * kIndexBytes + order +
         (sizes.groups + 1) * kBytesPerGroup + sizes.name_bytes * kBytesPerNameByte +
         GlbMaterials::MostBytes(source);
}

// Measured: a stream beside libdraco's copies of attributes and faces, its integers and its symbols.
uint64_t MostDracoBytes(const WrittenSizes& sizes) {
  constexpr uint64_t kBytesPerPoint = 64, kBytesPerTriangle = 48, kTableBytes = uint64_t{1} << 20;
  return sizes.records * (kBytesPerPoint + 4 * RecordBytes(sizes)) +
         sizes.faces * kBytesPerTriangle + sizes.corners * kIndexBytes + kTableBytes;
}

uint64_t Digits(uint64_t number) {
  uint64_t digits = 1;
  for (; number >= 10; number /= 10) ++digits;
  return digits;
}

// "-2.2250738585072014e-308" and "-1234567800000000", each with what comes before it.
constexpr uint64_t kDoubleTextBytes = 25, kFloatTextBytes = 18;

}  // namespace

WrittenSizes WrittenSizesOf(const PolygonMesh& mesh) {
  WrittenSizes sizes{.positions = mesh.positions.size(),
                     .normals = mesh.normals.size(),
                     .uvs = mesh.uvs.size(),
                     .records = mesh.corner_count(),
                     .corners = mesh.corner_count(),
                     .faces = mesh.face_count(),
                     .groups = mesh.group_names.size()};
  for (const std::string& name : mesh.group_names) sizes.name_bytes += name.size();
  uint32_t last = PolygonMesh::kNoAttribute;
  for (const uint32_t group : mesh.face_groups) {
    if (std::exchange(last, group) == group) continue;
    ++sizes.group_lines;
    sizes.group_line_bytes += mesh.group_names[group].size();
  }
  return sizes;
}

uint64_t MeshBytes(const WrittenSizes& sizes) {
  constexpr uint64_t kBytesPerName = sizeof(std::string) + 32;
  const uint64_t indices = 1u + (sizes.normals > 0 ? 1u : 0u) + (sizes.uvs > 0 ? 1u : 0u);
  return sizes.positions * sizeof(Vec3d) + sizes.normals * sizeof(Vec3f) +
         sizes.uvs * sizeof(Vec2f) + sizes.corners * indices * kIndexBytes +
         (sizes.faces + 1) * (1 + (sizes.groups > 0 ? 1 : 0)) * kIndexBytes +
         sizes.groups * kBytesPerName + sizes.name_bytes;
}

uint64_t MostObjBytes(const WrittenSizes& sizes) {
  constexpr uint64_t kLineBytes = 3;  // "vn", line end
  const uint64_t attributes = (sizes.normals > 0 ? 1 + Digits(sizes.normals) : 0) +
                              (sizes.uvs > 0 ? 1 + Digits(sizes.uvs) : 0);
  constexpr uint64_t kBlankAndSlash = 2;
  return kSmallBytes + sizes.positions * (3 * kDoubleTextBytes + kLineBytes) +
         sizes.normals * (3 * kFloatTextBytes + kLineBytes) +
         sizes.uvs * (2 * kFloatTextBytes + kLineBytes) + sizes.faces * 2 +
         sizes.corners * (kBlankAndSlash + Digits(sizes.positions) + attributes) +
         sizes.group_lines * sizeof("usemtl \n") + sizes.group_line_bytes;
}

uint64_t MostUsdBytes(const WrittenSizes& sizes) {
  constexpr uint64_t kBetween = 2;          // ", "
  constexpr uint64_t kBytesPerGroup = 900;  // a subset and a material, the names aside
  constexpr uint64_t kTimesNamed = 6, kMostSuffix = 12;
  const uint64_t attributes = (sizes.normals > 0 ? kBetween + Digits(sizes.normals) : 0) +
                              (sizes.uvs > 0 ? kBetween + Digits(sizes.uvs) : 0);
  return kSmallBytes + sizes.positions * 3 * (kFloatTextBytes + kBetween) +
         (sizes.normals + 1) * 3 * (kFloatTextBytes + kBetween) +
         (sizes.uvs + 1) * 2 * (kFloatTextBytes + kBetween) +
         sizes.corners * (kBetween + Digits(sizes.positions) + attributes) +
         sizes.faces * 2 * (kBetween + Digits(sizes.faces)) +
         sizes.groups * (kBytesPerGroup + kTimesNamed * kMostSuffix) +
         sizes.name_bytes * kTimesNamed;
}

uint64_t MostWritingBytes(MeshFormat format, const WrittenSizes& sizes, std::string_view source) {
  switch (format) {
    case MeshFormat::kObj:
      return MostObjBytes(sizes) + 4 * std::min<uint64_t>(source.size(), kMostLibraryBytes);
    case MeshFormat::kUsd:
      // Beside the text: names, faces by group, and copies of one attribute and its indices.
      return MostUsdBytes(sizes) + sizes.name_bytes + sizes.groups * 256 +
             sizes.faces * 3 * kIndexBytes + (sizes.normals + sizes.uvs + 2) * 2 * sizeof(Vec3f) +
             sizes.corners * kIndexBytes;
    case MeshFormat::kPly:
      return kSmallBytes + RecordTableBytes(sizes) + sizes.records * RecordBytes(sizes) +
             sizes.corners * kIndexBytes + sizes.faces * kIndexBytes;
    case MeshFormat::kStl:
      return kSmallBytes + sizes.faces * (4 * sizeof(Vec3f) + sizeof(uint16_t));
    case MeshFormat::kGlb:
      return RecordTableBytes(sizes) + MostGlbBytes(sizes, source);
    case MeshFormat::kDraco:
      return RecordTableBytes(sizes) + MostDracoBytes(sizes);
  }
  return 0;
}

}  // namespace latticed
