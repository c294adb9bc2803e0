// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Files that command lines name. Errors are one sentence with the file's name.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_FILES_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_FILES_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/sample_meshes.h"
#include "latticed/v1/mesh.pb.h"

namespace latticed::client {

[[nodiscard]] absl::StatusOr<std::string> ReadFile(const std::string& path);
[[nodiscard]] absl::Status WriteFile(const std::string& path, std::string_view bytes);

// The bytes of a mesh file. Its format follows from the name's extension.
struct MeshFile {
  std::string path;
  MeshFormat format = MeshFormat::kObj;
  std::string bytes;
};
[[nodiscard]] absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path);
// A name of 'latticectl sample' as the OBJ file that it writes, or else the file of that name.
[[nodiscard]] absl::StatusOr<MeshFile> SampleOrFile(const std::string& name,
                                                    int resolution = kDefaultSampleResolution);
// Draco included, unlike ReadMesh.
[[nodiscard]] absl::StatusOr<PolygonMesh> ParseMesh(const MeshFile& file);
// Any format, DRC included, by the path's extension.
[[nodiscard]] absl::Status WriteMeshFile(const std::string& path, const TriangleMesh& mesh);

[[nodiscard]] v1::MeshFormat ToProto(MeshFormat format);

// For CLI11: an error text for a path whose extension is no mesh format, else empty.
[[nodiscard]] std::string CheckMeshFileName(const std::string& path);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_FILES_H_
