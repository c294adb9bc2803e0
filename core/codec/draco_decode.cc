// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_decode.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <utility>

#include "core/base/bounds.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_announcement.h"
#include "core/codec/draco_geometry.h"
#include "core/codec/draco_mesh_decoder.h"
#include "core/mesh/triangulated.h"
#include "core/mesh/write/vertex_records.h"
#include "draco/compression/decode.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using Kind = draco::GeometryAttribute;

absl::Status Malformed(std::string_view problem) {
  return error::MalformedFile("DRACO", "the stream", problem);
}

absl::StatusOr<std::unique_ptr<draco::PointCloud>> DecodeCloud(std::span<const uint8_t> bytes,
                                                               bool skip_transforms) {
  LATTICED_ASSIGN_OR_RETURN(const auto announcement, ReadDracoAnnouncement(bytes));
  if (announcement.points > limits::kMaxChunkPoints) {
    return Malformed(fmt::format("announces {} points, a chunk has {} at most", announcement.points,
                                 limits::kMaxChunkPoints));
  }
  if (announcement.is_kd_tree) return Malformed("is a k-d tree, a chunk keeps its order");
  LATTICED_RETURN_IF_ERROR(CheckDracoSize(announcement, bytes.size()));
  draco::Decoder decoder;
  if (skip_transforms) {
    decoder.SetSkipAttributeTransform(Kind::POSITION);
    decoder.SetSkipAttributeTransform(Kind::NORMAL);
  }
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  try {
    auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!cloud.ok()) return Malformed(cloud.status().error_msg_string());
    return std::move(cloud).value();
  } catch (const std::exception& e) {  // std::bad_alloc and std::length_error of corrupt tables
    return Malformed(e.what());
  }
}

// The values of an attribute by point. T must be how the attribute is stored.
template <typename T>
absl::StatusOr<std::vector<T>> Values(const draco::PointCloud& cloud, Kind::Type kind,
                                      int8_t components) {
  const draco::PointAttribute* attribute = cloud.GetNamedAttribute(kind);
  if (attribute == nullptr) return std::vector<T>{};
  if (attribute->num_components() != components) return Malformed("has an unexpected attribute");
  const auto width = static_cast<size_t>(components);
  std::vector<T> values(width * cloud.num_points());
  for (uint32_t p = 0; p < cloud.num_points(); ++p) {
    const auto index = attribute->mapped_index(draco::PointIndex(p));
    if (!attribute->ConvertValue<T>(index, components, &values[width * p])) {
      return Malformed("has an attribute value of another type");
    }
  }
  return values;
}

// Copies the values of an attribute, and per corner which one it uses; nothing for null.
template <typename Vec, size_t N, typename Scalar>
absl::Status CopyAttribute(const draco::Mesh& mesh, const draco::PointAttribute* attribute,
                           std::vector<Vec>& values, std::vector<uint32_t>& corners) {
  if (attribute == nullptr || attribute->num_components() != N) return absl::OkStatus();
  values.resize(attribute->size());
  for (uint32_t v = 0; v < values.size(); ++v) {
    Scalar value[N];
    if (!attribute->ConvertValue<Scalar>(draco::AttributeValueIndex(v), N, value)) {
      return Malformed("has an attribute value that is no number");
    }
    if constexpr (N == 3) values[v] = {value[0], value[1], value[2]};
    if constexpr (N == 2) values[v] = {value[0], value[1]};
  }
  corners.reserve(3 * static_cast<size_t>(mesh.num_faces()));
  for (uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& point : mesh.face(draco::FaceIndex(f))) {
      if (point.value() >= mesh.num_points()) return Malformed("has a face index out of range");
      const uint32_t index = attribute->mapped_index(point).value();
      if (index >= values.size()) return Malformed("maps a point to no attribute value");
      corners.push_back(index);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<PolygonMesh> ToPolygonMesh(const draco::Mesh& mesh) {
  PolygonMesh result;
  const auto* positions = mesh.GetNamedAttribute(Kind::POSITION);
  if (positions == nullptr || positions->num_components() != 3) {
    return Malformed("has no positions of three components");
  }
  LATTICED_RETURN_IF_ERROR(
      CopyAttribute<Vec3d, 3, double>(mesh, positions, result.positions, result.corner_vertices));
  LATTICED_RETURN_IF_ERROR(CopyAttribute<Vec3f, 3, float>(
      mesh, mesh.GetNamedAttribute(Kind::NORMAL), result.normals, result.corner_normals));
  LATTICED_RETURN_IF_ERROR(CopyAttribute<Vec2f, 2, float>(
      mesh, mesh.GetNamedAttribute(Kind::TEX_COORD), result.uvs, result.corner_uvs));
  result.face_offsets.resize(mesh.num_faces() + size_t{1});
  for (uint32_t f = 0; f <= mesh.num_faces(); ++f) result.face_offsets[f] = 3 * f;
  return result;
}

// A texel of a 4096 x 4096 texture, however coarse positions and normals are wanted.
constexpr int kLeastUvBits = 12;

}  // namespace

absl::StatusOr<DecodedChunk> DecodeDracoChunk(std::span<const uint8_t> bytes) {
  LATTICED_ASSIGN_OR_RETURN(const auto cloud, DecodeCloud(bytes, /*skip_transforms=*/false));
  LATTICED_ASSIGN_OR_RETURN(auto positions, Values<float>(*cloud, Kind::POSITION, 3));
  LATTICED_ASSIGN_OR_RETURN(auto normals, Values<float>(*cloud, Kind::NORMAL, 3));
  if (positions.empty() && cloud->num_points() > 0) return Malformed("has no positions");
  return DecodedChunk{std::move(positions), std::move(normals)};
}

absl::StatusOr<DecodedIntegers> DecodeDracoChunkIntegers(std::span<const uint8_t> bytes) {
  LATTICED_ASSIGN_OR_RETURN(const auto cloud, DecodeCloud(bytes, /*skip_transforms=*/true));
  LATTICED_ASSIGN_OR_RETURN(auto positions, Values<uint32_t>(*cloud, Kind::POSITION, 3));
  LATTICED_ASSIGN_OR_RETURN(auto normals, Values<uint32_t>(*cloud, Kind::NORMAL, 2));
  if (positions.empty() && cloud->num_points() > 0) return Malformed("has no positions");
  return DecodedIntegers{std::move(positions), std::move(normals)};
}

absl::StatusOr<PolygonMesh> ReadDracoMesh(std::string_view bytes, ReadingMemory* memory) {
  LATTICED_ASSIGN_OR_RETURN(
      const auto announcement,
      ReadDracoAnnouncement({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}));
  if (!announcement.is_mesh) return Malformed("is a point cloud; a mesh is needed");
  LATTICED_RETURN_IF_ERROR(CheckDracoSize(announcement, bytes.size()));
  try {
    LATTICED_ASSIGN_OR_RETURN(const auto decoded, DecodeDracoMesh(announcement, bytes, memory));
    auto mesh = ToPolygonMesh(*decoded);
    if (!mesh.ok()) return mesh;
    if (auto status = Validate(*mesh); !status.ok())
      return Malformed(std::string(status.message()));
    return mesh;
  } catch (const std::bad_alloc&) {
    return Malformed("needs more memory than its points and faces explain, or than there is");
  } catch (const std::exception& e) {  // std::length_error of corrupt tables
    return Malformed(e.what());
  }
}

absl::StatusOr<std::string> WriteDracoMesh(const PolygonMesh& mesh, int position_bits,
                                           int normal_bits) {
  if (!IsTriangular(mesh)) {
    LATTICED_ASSIGN_OR_RETURN(const auto triangles, Triangulated(mesh));
    return WriteDracoMesh(triangles, position_bits, normal_bits);
  }
  Bounds bounds;
  for (const Vec3d p : mesh.positions) bounds.Extend(p);
  const Vec3f origin = ToFloat(bounds.empty() ? Vec3d{} : bounds.min);
  const Vec3d extent = bounds.empty() ? Vec3d{} : bounds.max - ToDouble(origin);
  const double longest = std::max({extent.x, extent.y, extent.z});
  const VertexRecords vertices = MakeVertexRecords(mesh);
  const size_t count = vertices.records.size();
  DracoGeometry geometry{.point_count = count,
                         .position_bits = position_bits,
                         .normal_bits = mesh.has_normals() ? normal_bits : 0,
                         .uv_bits = mesh.has_uvs() ? std::max(position_bits, kLeastUvBits) : 0,
                         .origin = {origin.x, origin.y, origin.z},
                         .range = longest > 0 ? static_cast<float>(longest) : 1.0f};
  const double top = static_cast<double>((1 << position_bits) - 1);
  geometry.grid_positions.reserve(3 * count);
  if (mesh.has_normals()) geometry.normals.reserve(3 * count);
  if (mesh.has_uvs()) geometry.uvs.reserve(2 * count);
  for (const VertexRecord& record : vertices.records) {
    const Vec3d grid =
        (mesh.positions[record.position] - ToDouble(origin)) * (top / double{geometry.range});
    for (int axis = 0; axis < 3; ++axis) {
      geometry.grid_positions.push_back(
          static_cast<float>(std::clamp(std::round(grid[axis]), 0.0, top)));
    }
    const Vec3f n = NormalOf(mesh, record);
    if (mesh.has_normals()) geometry.normals.insert(geometry.normals.end(), {n.x, n.y, n.z});
    const Vec2f uv = UvOf(mesh, record);
    if (mesh.has_uvs()) geometry.uvs.insert(geometry.uvs.end(), {uv.x, uv.y});
  }
  const std::vector<uint32_t>& corners = vertices.corner_records;
  std::vector<std::array<uint32_t, 3>> triangles;
  triangles.reserve(mesh.face_count());
  for (size_t c = 0; c < corners.size(); c += 3) {
    triangles.push_back({corners[c], corners[c + 1], corners[c + 2]});
  }
  LATTICED_ASSIGN_OR_RETURN(const auto stream, EncodeDraco(geometry, TriangleSpan(triangles)));
  return std::string(stream.begin(), stream.end());
}

}  // namespace latticed
