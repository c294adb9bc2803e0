// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/mesh_header.h"

#include <array>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/base/utf8.h"
#include "core/codec/draco_decode.h"
#include "core/mesh/mesh_io.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/base/labels.h"
#include "server/wire/converters.h"
#include "server/wire/enum_table.h"
#include "server/wire/mesh_units.h"
#include "server/wire/raw_mesh.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

// Bytes of the tag and length of a group in its Mesh.
constexpr size_t kGroupOverheadBytes = 4;

Labels LabelsOf(const v1::MeshHeader& header) {
  return Labels(header.labels().begin(), header.labels().end());
}

// Enums of the wire and the values of a StoredMesh.
constexpr auto kUploadFormats = std::to_array<std::pair<v1::MeshFormat, UploadFormat>>(
    {{v1::MESH_FORMAT_OBJ, UploadFormat::kObj},
     {v1::MESH_FORMAT_PLY, UploadFormat::kPly},
     {v1::MESH_FORMAT_STL, UploadFormat::kStl},
     {v1::MESH_FORMAT_GLB, UploadFormat::kGlb},
     {v1::MESH_FORMAT_DRACO, UploadFormat::kDraco},
     {v1::MESH_FORMAT_RAW, UploadFormat::kRaw}});

absl::Status CheckWords(const v1::MeshHeader& header) {
  LATTICED_RETURN_IF_ERROR(error::CheckRange("header.name",
                                             static_cast<double>(header.name().size()), 0,
                                             static_cast<double>(limits::kMaxNameBytes)));
  if (header.has_sha256() && !IsSha256Hex(absl::AsciiStrToLower(header.sha256()))) {
    return error::InvalidField("header.sha256", "expected 64 hexadecimal digits");
  }
  return CheckLabels(LabelsOf(header), "header.labels");
}

void FillGroups(const PolygonMesh& mesh, v1::Mesh& out) {
  std::vector<uint64_t> faces(mesh.group_names.size(), 0);
  for (const uint32_t group : mesh.face_groups) ++faces[group];
  size_t bytes = 0;
  for (size_t i = 0; i < faces.size(); ++i) {
    v1::MeshGroup group;
    // Cut before ValidUtf8 too, because a name in a file may have any length.
    const std::string name = ValidUtf8(
        std::string_view(mesh.group_names[i]).substr(0, limits::kMaxShownGroupNameBytes + 4));
    group.set_name(std::string(CutUtf8(name, limits::kMaxShownGroupNameBytes)));
    group.set_faces(faces[i]);
    bytes += group.ByteSizeLong() + kGroupOverheadBytes;
    if (bytes > limits::kMaxShownGroupBytes) return;
    *out.add_groups() = std::move(group);
  }
}

}  // namespace

absl::StatusOr<UploadHeader> FromProto(const v1::MeshHeader& header, uint64_t max_mesh_bytes) {
  UploadHeader out;
  if (header.format() == v1::MESH_FORMAT_UNSPECIFIED) {
    return error::InvalidField("header.format", "is required");
  }
  LATTICED_ASSIGN_OR_RETURN(out.mesh.format,
                            ReadEnum(kUploadFormats, header.format(), "header.format"));
  if (header.total_bytes() == 0 || header.total_bytes() > max_mesh_bytes) {
    return error::OutOfRange("header.total_bytes", static_cast<double>(header.total_bytes()), 1,
                             static_cast<double>(max_mesh_bytes));
  }
  LATTICED_ASSIGN_OR_RETURN(out.mesh.units, MeshUnitsFromProto(header.units(), "header.units"));
  if (out.mesh.format == UploadFormat::kGlb) out.mesh.units = WithGltfDefaults(out.mesh.units);
  LATTICED_RETURN_IF_ERROR(CheckWords(header));
  if (header.has_raw_layout() != (out.mesh.format == UploadFormat::kRaw)) {
    return error::InvalidField("header.raw_layout",
                               "goes with MESH_FORMAT_RAW, and only with that");
  }
  if (header.has_raw_layout()) {
    LATTICED_RETURN_IF_ERROR(CheckRawLayout(header.raw_layout(), header.total_bytes()));
  }
  out.mesh.name = header.name();
  out.mesh.labels = LabelsOf(header);
  out.mesh.layout = header.raw_layout().SerializeAsString();
  out.total_bytes = header.total_bytes();
  out.sha256 = header.sha256();
  return out;
}

absl::StatusOr<PolygonMesh> ReadUpload(const MeshDescription& described, std::string_view bytes,
                                       ReadingMemory* memory) {
  switch (described.format) {
    case UploadFormat::kObj:
      return ReadMesh(MeshFormat::kObj, bytes, memory);
    case UploadFormat::kPly:
      return ReadMesh(MeshFormat::kPly, bytes, memory);
    case UploadFormat::kStl:
      return ReadMesh(MeshFormat::kStl, bytes, memory);
    case UploadFormat::kGlb:
      return ReadMesh(MeshFormat::kGlb, bytes, memory);
    case UploadFormat::kDraco:
      return ReadDracoMesh(bytes, memory);
    case UploadFormat::kRaw:
      v1::RawLayout layout;
      layout.ParseFromString(described.layout);
      return ReadRawMesh(layout, bytes, memory);
  }
  return absl::InternalError("no format");
}

v1::MeshHeader HeaderOf(const StoredMesh& mesh) {
  v1::MeshHeader header;
  header.set_name(mesh.name);
  header.set_format(WriteEnum(kUploadFormats, mesh.format));
  header.set_total_bytes(mesh.bytes->size());
  header.set_sha256(std::string(IdOf(mesh.id)));
  *header.mutable_units() = ToProto(mesh.units);
  header.mutable_labels()->insert(mesh.labels.begin(), mesh.labels.end());
  if (mesh.format == UploadFormat::kRaw) header.mutable_raw_layout()->ParseFromString(mesh.layout);
  return header;
}

v1::Mesh ToProto(const StoredMesh& mesh, const MeshUse& use, bool with_groups) {
  v1::Mesh out;
  out.set_id(std::string(IdOf(mesh.id)));
  out.set_name(mesh.name);
  out.set_format(WriteEnum(kUploadFormats, mesh.format));
  out.set_total_bytes(mesh.bytes->size());
  out.set_vertices(mesh.mesh->positions.size());
  out.set_faces(mesh.mesh->face_count());
  out.set_corners(mesh.mesh->corner_count());
  *out.mutable_bounds() = ToProto(mesh.bounds);
  out.set_has_normals(mesh.mesh->has_normals());
  out.set_has_uvs(mesh.mesh->has_uvs());
  out.set_has_weights(!mesh.mesh->weights.empty());
  if (with_groups) FillGroups(*mesh.mesh, out);
  out.set_host_bytes(mesh.MemoryBytes());
  out.set_device_bytes(use.device_bytes);
  out.mutable_labels()->insert(mesh.labels.begin(), mesh.labels.end());
  out.set_owner(mesh.owner);
  const v1::MeshUnits units = ToProto(mesh.units);
  out.set_up_axis(units.up_axis());
  out.set_meters_per_unit(units.meters_per_unit());
  SetTime(mesh.create_time, *out.mutable_create_time());
  out.set_scenes(use.scenes);
  return out;
}

}  // namespace latticed
