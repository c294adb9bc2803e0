// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_geometry.h"
#include "core/base/status_macros.h"

#include <cstring>
#include <memory>

#include "draco/compression/expert_encode.h"
#include "draco/mesh/mesh.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Speed hardly matters to a sequential stream; 10 is the fastest.
constexpr int kSpeed = 10;
constexpr size_t kQuantisationBytes(size_t components) { return 4 * components + 4 + 1; }

using Kind = draco::GeometryAttribute;

int AddAttribute(draco::PointCloud& cloud, Kind::Type kind, int8_t components,
                 const std::vector<float>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(kind, nullptr, static_cast<uint8_t>(components), draco::DT_FLOAT32, false,
                 static_cast<int64_t>(sizeof(float)) * components, 0);
  const int id = cloud.AddAttribute(attribute, /*identity_mapping=*/true, cloud.num_points());
  cloud.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(float));
  return id;
}

void SetTriangles(draco::Mesh& mesh, TriangleSpan triangles) {
  mesh.SetNumFaces(triangles.size());
  for (uint32_t f = 0; f < triangles.size(); ++f) {
    draco::Mesh::Face face;
    for (size_t c = 0; c < 3; ++c) face[c] = triangles[f][c];
    mesh.SetFace(draco::FaceIndex(f), face);
  }
}

absl::Status PatchTransform(const DracoGeometry& geometry, std::vector<uint8_t>& stream) {
  size_t from_end = kQuantisationBytes(3);
  if (geometry.normal_bits > 0) from_end += 1;
  if (geometry.uv_bits > 0) from_end += kQuantisationBytes(2);
  float grid_range = 0;
  if (stream.size() >= from_end) {
    std::memcpy(&grid_range, &stream[stream.size() - from_end + 12], sizeof(grid_range));
  }
  if (grid_range != static_cast<float>((1 << geometry.position_bits) - 1)) {
    return absl::InternalError("libdraco wrote its quantisation transform in an unknown place");
  }
  uint8_t* transform = &stream[stream.size() - from_end];
  std::memcpy(transform, geometry.origin.data(), sizeof(geometry.origin));
  std::memcpy(transform + sizeof(geometry.origin), &geometry.range, sizeof(geometry.range));
  return absl::OkStatus();
}

// How a stream says which points its triangles join. kNone: a point cloud.
enum class Connectivity { kNone, kCompressed, kRaw };

void SetOptions(const DracoGeometry& geometry, int position, int normal, int uv,
                Connectivity connectivity, draco::ExpertEncoder& encoder) {
  const float zero[3] = {0, 0, 0};
  encoder.SetSpeedOptions(kSpeed, kSpeed);
  encoder.SetEncodingMethod(connectivity == Connectivity::kNone
                                ? int{draco::POINT_CLOUD_SEQUENTIAL_ENCODING}
                                : int{draco::MESH_SEQUENTIAL_ENCODING});
  encoder.options().SetGlobalBool("compress_connectivity",
                                  connectivity == Connectivity::kCompressed);
  encoder.SetAttributeExplicitQuantization(position, geometry.position_bits, 3, zero,
                                           static_cast<float>((1 << geometry.position_bits) - 1));
  if (normal >= 0) encoder.SetAttributeQuantization(normal, geometry.normal_bits);
  if (uv >= 0) encoder.SetAttributeQuantization(uv, geometry.uv_bits);
  for (const int id : {position, normal, uv}) {
    if (id >= 0) (void)encoder.SetAttributePredictionScheme(id, draco::PREDICTION_DIFFERENCE);
  }
}

absl::StatusOr<std::vector<uint8_t>> EncodeAs(const DracoGeometry& geometry, TriangleSpan triangles,
                                              Connectivity connectivity) {
  const bool is_mesh = connectivity != Connectivity::kNone;
  auto cloud = is_mesh ? std::make_unique<draco::Mesh>() : std::make_unique<draco::PointCloud>();
  cloud->set_num_points(static_cast<uint32_t>(geometry.point_count));
  const int position =
      AddAttribute(*cloud, draco::GeometryAttribute::POSITION, 3, geometry.grid_positions);
  const int normal =
      geometry.normal_bits > 0
          ? AddAttribute(*cloud, draco::GeometryAttribute::NORMAL, 3, geometry.normals)
          : -1;
  const int uv = geometry.uv_bits > 0
                     ? AddAttribute(*cloud, draco::GeometryAttribute::TEX_COORD, 2, geometry.uvs)
                     : -1;
  draco::EncoderBuffer buffer;
  const auto encode = [&](draco::ExpertEncoder encoder) {
    SetOptions(geometry, position, normal, uv, connectivity, encoder);
    return encoder.EncodeToBuffer(&buffer);
  };
  draco::Status status;
  if (is_mesh) {
    auto& mesh = static_cast<draco::Mesh&>(*cloud);
    SetTriangles(mesh, triangles);
    status = encode(draco::ExpertEncoder(mesh));
  } else {
    status = encode(draco::ExpertEncoder(*cloud));
  }
  if (!status.ok()) {
    return absl::InternalError(
        fmt::format("libdraco cannot encode: {}", status.error_msg_string()));
  }
  std::vector<uint8_t> stream(buffer.data(), buffer.data() + buffer.size());
  LATTICED_RETURN_IF_ERROR(PatchTransform(geometry, stream));
  return stream;
}

}  // namespace

absl::StatusOr<std::vector<uint8_t>> EncodeDraco(const DracoGeometry& geometry,
                                                 std::optional<TriangleSpan> triangles) {
  if (!triangles.has_value()) return EncodeAs(geometry, {}, Connectivity::kNone);
  auto stream = EncodeAs(geometry, *triangles, Connectivity::kCompressed);
  // Stock decoders refuse a stream with less than three bytes a face after its header, however well
  // the indices were compressed; raw indices always take that much.
  constexpr size_t kMostHeaderBytes = 32;
  if (stream.ok() && stream->size() < kMostHeaderBytes + 3 * triangles->size()) {
    return EncodeAs(geometry, *triangles, Connectivity::kRaw);
  }
  return stream;
}

}  // namespace latticed
