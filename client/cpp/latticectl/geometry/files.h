// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads and writes files that a command line names. Errors are one sentence with the file's name.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_FILES_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_FILES_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/sample_meshes.h"
#include "core/mesh/write/write_mesh.h"
#include "latticed/v1/mesh.pb.h"

namespace latticed::client {

[[nodiscard]] absl::Status WriteFile(const std::string& path, std::string_view bytes);

// The bytes of a mesh file. Its format follows from the name's extension.
struct MeshFile {
  std::string path;
  MeshFormat format = MeshFormat::kObj;
  std::string bytes;
};
[[nodiscard]] absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path);
// For a name that 'latticectl sample' takes, returns the OBJ file of that sample; else reads a file.
[[nodiscard]] absl::StatusOr<MeshFile> SampleOrFile(const std::string& name,
                                                    int resolution = kDefaultSampleResolution);
// Parses any format, Draco included (ReadMesh does not know Draco).
[[nodiscard]] absl::StatusOr<PolygonMesh> ParseMesh(const MeshFile& file);
// Writes any format, DRC included; the path's extension selects it.
[[nodiscard]] absl::Status WriteMeshFile(const std::string& path, const PolygonMesh& mesh,
                                         const FileExtras& extras);

[[nodiscard]] v1::MeshFormat ToProto(MeshFormat format);

// A check for CLI11: returns an error text if the path's extension is no format that can be written, else "".
[[nodiscard]] std::string CheckMeshFileName(const std::string& path);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_FILES_H_
