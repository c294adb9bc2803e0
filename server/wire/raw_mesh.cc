// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/raw_mesh.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

static_assert(std::endian::native == std::endian::little, "RAW is read by copying");

constexpr uint64_t kMinFaceSize = 3;

// The number of elements of each array. Each is below 2^32, so 64 bits hold the sum of their bytes.
struct RawSizes {
  uint64_t vertices = 0, faces = 0, corners = 0;
  uint64_t position_bytes = 0;  // of one coordinate
  uint64_t sizes = 0, normals = 0, uvs = 0, groups = 0, weights = 0;

  uint64_t TotalBytes() const {
    return vertices * 3 * position_bytes + 4 * (sizes + corners + groups + weights) + 12 * normals +
           8 * uvs;
  }
};

uint64_t Elements(v1::AttributeDomain domain, const RawSizes& sizes) {
  switch (domain) {
    case v1::ATTRIBUTE_DOMAIN_VERTEX:
      return sizes.vertices;
    case v1::ATTRIBUTE_DOMAIN_CORNER:
      return sizes.corners;
    default:
      return 0;
  }
}

RawSizes SizesOf(const v1::RawLayout& layout) {
  RawSizes sizes;
  sizes.vertices = layout.vertex_count();
  sizes.faces = layout.face_count();
  const bool implied = layout.corner_count() == 0 && layout.face_size() != 0;
  sizes.corners = implied ? layout.face_count() * layout.face_size() : layout.corner_count();
  sizes.position_bytes = layout.position_type() == v1::SCALAR_TYPE_FLOAT64 ? 8 : 4;
  sizes.sizes = layout.face_size() == 0 ? layout.face_count() : 0;
  sizes.normals = Elements(layout.normals(), sizes);
  sizes.uvs = Elements(layout.uvs(), sizes);
  sizes.groups = layout.group_names().empty() ? 0 : layout.face_count();
  sizes.weights = layout.weights() ? layout.vertex_count() : 0;
  return sizes;
}

// Takes arrays from the front of the bytes. CheckRawLayout has checked that there are enough.
class RawReader {
 public:
  explicit RawReader(std::string_view bytes) : rest_(bytes) {}

  template <typename T>
  std::vector<T> Take(uint64_t count) {
    std::vector<T> values(count);
    const auto bytes = std::as_writable_bytes(std::span(values));
    std::copy_n(std::as_bytes(std::span(rest_)).begin(), bytes.size(), bytes.begin());
    rest_.remove_prefix(bytes.size());
    return values;
  }

 private:
  std::string_view rest_;
};

// More than reading takes: the mesh, and one array of numbers or sizes beside it.
uint64_t MeshBytes(const RawSizes& sizes) {
  return 2 * sizes.vertices * sizeof(Vec3d) + 2 * sizes.faces * sizeof(uint32_t) +
         3 * sizes.corners * sizeof(uint32_t) + sizes.normals * sizeof(Vec3f) +
         sizes.uvs * sizeof(Vec2f) + sizes.groups * sizeof(uint32_t) +
         sizes.weights * sizeof(float);
}

std::vector<Vec3d> TakePositions(RawReader& reader, const RawSizes& sizes) {
  std::vector<Vec3d> positions;
  positions.reserve(sizes.vertices);
  const auto append = [&positions](const auto& numbers) {
    for (size_t i = 0; i + 2 < numbers.size(); i += 3) {
      positions.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
    }
  };
  if (sizes.position_bytes == 8) {
    append(reader.Take<double>(sizes.vertices * 3));
  } else {
    append(reader.Take<float>(sizes.vertices * 3));
  }
  return positions;
}

// Returns 0 and the end of each face; kInvalidArgument if the faces do not fill the corners.
absl::StatusOr<std::vector<uint32_t>> TakeFaceOffsets(RawReader& reader, const RawSizes& sizes,
                                                      uint32_t face_size) {
  const std::vector<uint32_t> face_sizes = face_size == 0
                                               ? reader.Take<uint32_t>(sizes.faces)
                                               : std::vector<uint32_t>(sizes.faces, face_size);
  std::vector<uint32_t> offsets{0};
  offsets.reserve(sizes.faces + 1);
  uint64_t end = 0;
  for (size_t face = 0; face < face_sizes.size(); ++face) {
    end += face_sizes[face];
    if (face_sizes[face] < kMinFaceSize || end > sizes.corners) {
      return error::MalformedFile("RAW", fmt::format("face {}", face),
                                  fmt::format("has {} corners; at least 3, and {} in all",
                                              face_sizes[face], sizes.corners));
    }
    offsets.push_back(static_cast<uint32_t>(end));
  }
  if (end != sizes.corners) {
    return error::MalformedFile("RAW", "face sizes",
                                fmt::format("sum up to {} corners, not {}", end, sizes.corners));
  }
  return offsets;
}

std::vector<uint32_t> CornerIndices(v1::AttributeDomain domain, const PolygonMesh& mesh) {
  if (domain == v1::ATTRIBUTE_DOMAIN_VERTEX) return mesh.corner_vertices;
  std::vector<uint32_t> indices(mesh.corner_vertices.size());
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

absl::Status CheckCount(const char* field, uint64_t got, uint64_t highest) {
  if (got >= 1 && got <= highest) return absl::OkStatus();
  return error::OutOfRange(field, static_cast<double>(got), 1, static_cast<double>(highest));
}

absl::Status CheckKnown(bool known, std::string_view field, std::string_view what, int value) {
  if (known) return absl::OkStatus();
  return error::Unsupported(fmt::format("header.raw_layout.{}", field),
                            fmt::format("{} {}", what, value));
}

}  // namespace

absl::Status CheckRawLayout(const v1::RawLayout& layout, uint64_t total_bytes) {
  constexpr uint64_t kMaxCorners = PolygonMesh::kNoAttribute - 1;
  LATTICED_RETURN_IF_ERROR(CheckKnown(v1::ScalarType_IsValid(layout.position_type()),
                                      "position_type", "type", layout.position_type()));
  LATTICED_RETURN_IF_ERROR(CheckKnown(v1::AttributeDomain_IsValid(layout.normals()), "normals",
                                      "domain", layout.normals()));
  LATTICED_RETURN_IF_ERROR(
      CheckKnown(v1::AttributeDomain_IsValid(layout.uvs()), "uvs", "domain", layout.uvs()));
  LATTICED_RETURN_IF_ERROR(CheckCount("header.raw_layout.vertex_count", layout.vertex_count(),
                                      limits::kMaxMeshVertices));
  LATTICED_RETURN_IF_ERROR(
      CheckCount("header.raw_layout.face_count", layout.face_count(), limits::kMaxMeshFaces));
  const uint32_t face_size = layout.face_size();
  if (face_size != 0 && (face_size < kMinFaceSize || face_size > limits::kMaxFaceCorners)) {
    return error::OutOfRange("header.raw_layout.face_size", face_size, kMinFaceSize,
                             limits::kMaxFaceCorners);
  }
  const RawSizes sizes = SizesOf(layout);
  LATTICED_RETURN_IF_ERROR(
      CheckCount("header.raw_layout.corner_count", sizes.corners, kMaxCorners));
  if (sizes.TotalBytes() != total_bytes) {
    return error::InvalidField(
        "header.raw_layout",
        fmt::format("describes {} bytes, total_bytes is {}", sizes.TotalBytes(), total_bytes));
  }
  return absl::OkStatus();
}

absl::StatusOr<PolygonMesh> ReadRawMesh(const v1::RawLayout& layout, std::string_view bytes,
                                        ReadingMemory* memory) {
  const RawSizes sizes = SizesOf(layout);
  if (memory != nullptr) LATTICED_RETURN_IF_ERROR(memory->Hold(MeshBytes(sizes)));
  RawReader reader(bytes);
  PolygonMesh mesh;
  mesh.positions = TakePositions(reader, sizes);
  LATTICED_ASSIGN_OR_RETURN(mesh.face_offsets, TakeFaceOffsets(reader, sizes, layout.face_size()));
  mesh.corner_vertices = reader.Take<uint32_t>(sizes.corners);
  if (sizes.normals > 0) {
    mesh.normals = reader.Take<Vec3f>(sizes.normals);
    mesh.corner_normals = CornerIndices(layout.normals(), mesh);
  }
  if (sizes.uvs > 0) {
    mesh.uvs = reader.Take<Vec2f>(sizes.uvs);
    mesh.corner_uvs = CornerIndices(layout.uvs(), mesh);
  }
  mesh.group_names.assign(layout.group_names().begin(), layout.group_names().end());
  mesh.face_groups = reader.Take<uint32_t>(sizes.groups);
  mesh.weights = reader.Take<float>(sizes.weights);
  if (absl::Status status = Validate(mesh); !status.ok()) {
    return error::MalformedFile("RAW", "the arrays", std::string(status.message()));
  }
  return mesh;
}

}  // namespace latticed
