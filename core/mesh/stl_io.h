// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// STL, ascii and binary.
//
//   binary: 80 bytes of header, uint32 count, count x { float normal[3], vertices[3][3]; uint16 }
//
// A file is binary when its size fits the count, also when its header starts with "solid". Vertices
// with the same bits are one. Facet normals are not kept: they say no more than the facets do. In
// an ascii file of several solids each is a group.
//
// Errors   reading: kInvalidArgument, reason MALFORMED_FILE, naming the line or byte
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_STL_IO_H_
#define LATTICED_CORE_MESH_STL_IO_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<PolygonMesh> ReadStl(std::string_view bytes);
// Binary. Positions become float, which tells far-away vertices apart no more.
[[nodiscard]] std::string WriteStl(const TriangleMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_STL_IO_H_
