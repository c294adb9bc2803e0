// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One mesh in every form that an upload may have.
#ifndef LATTICED_TESTS_SERVER_MESHES_MESH_FILES_H_
#define LATTICED_TESTS_SERVER_MESHES_MESH_FILES_H_

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "latticed/v1/mesh.pb.h"

namespace latticed::testing {

struct MeshFile {
  std::string name;
  v1::MeshHeader header;
  std::string bytes;
};

[[nodiscard]] MeshFile MakeMeshFile(const std::string& name, v1::MeshFormat format,
                                    std::string bytes);

// The unit cube of 8 vertices and 12 triangles, facing outwards: OBJ, three PLYs, two STLs, GLB, DRACO and RAW.
[[nodiscard]] std::vector<MeshFile> CubeFiles();

// The bytes of an array, little-endian as on the wire.
template <typename T>
std::string BytesOf(const std::vector<T>& values) {
  static_assert(std::endian::native == std::endian::little);
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_MESHES_MESH_FILES_H_
