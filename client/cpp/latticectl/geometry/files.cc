// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/files.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "core/base/read_file.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_decode.h"
#include "core/mesh/mesh_io.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

absl::Status CannotRead(const std::string& path, std::string_view why) {
  return absl::NotFoundError(fmt::format("cannot read {}: {}", path, why));
}

absl::Status InFile(const std::string& path, const absl::Status& status) {
  return absl::Status(status.code(), fmt::format("{}: {}", path, std::string(status.message())));
}

}  // namespace

absl::Status WriteFile(const std::string& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) return absl::OkStatus();
  return absl::UnknownError(fmt::format("cannot write {}: {}", path, std::strerror(errno)));
}

absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path) {
  const auto format = MeshFormatFromFileName(path);
  if (!format.ok()) return InFile(path, format.status());
  if (*format == MeshFormat::kUsd) {
    return absl::InvalidArgumentError(fmt::format("{}: USD is written, but not read", path));
  }
  LATTICED_ASSIGN_OR_RETURN(auto bytes, ReadFile(path));
  if (bytes.empty()) return CannotRead(path, "it is empty");
  return MeshFile{path, *format, std::move(bytes)};
}

absl::StatusOr<MeshFile> SampleOrFile(const std::string& name, int resolution) {
  const auto names = SampleMeshNames();
  if (std::find(names.begin(), names.end(), name) == names.end()) return ReadMeshFile(name);
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, MakeSampleMesh(name, resolution));
  return MeshFile{name + ".obj", MeshFormat::kObj, WriteObj(mesh)};
}

absl::StatusOr<PolygonMesh> ParseMesh(const MeshFile& file) {
  auto mesh = file.format == MeshFormat::kDraco ? ReadDracoMesh(file.bytes)
                                                : ReadMesh(file.format, file.bytes);
  if (!mesh.ok()) return InFile(file.path, mesh.status());
  return mesh;
}

absl::Status WriteMeshFile(const std::string& path, const PolygonMesh& mesh,
                           const FileExtras& extras) {
  LATTICED_ASSIGN_OR_RETURN(const auto format, MeshFormatFromFileName(path));
  const auto bytes =
      format == MeshFormat::kDraco ? WriteDracoMesh(mesh) : WriteMesh(format, mesh, extras);
  if (!bytes.ok()) return InFile(path, bytes.status());
  return WriteFile(path, *bytes);
}

v1::MeshFormat ToProto(MeshFormat format) {
  switch (format) {
    case MeshFormat::kObj:
      return v1::MESH_FORMAT_OBJ;
    case MeshFormat::kPly:
      return v1::MESH_FORMAT_PLY;
    case MeshFormat::kStl:
      return v1::MESH_FORMAT_STL;
    case MeshFormat::kGlb:
      return v1::MESH_FORMAT_GLB;
    case MeshFormat::kDraco:
      return v1::MESH_FORMAT_DRACO;
    case MeshFormat::kUsd:
      break;  // is not uploaded
  }
  return v1::MESH_FORMAT_UNSPECIFIED;
}

std::string CheckMeshFileName(const std::string& path) {
  const auto format = MeshFormatFromFileName(path);
  return format.ok() ? "" : fmt::format("{}: {}", path, std::string(format.status().message()));
}

}  // namespace latticed::client
