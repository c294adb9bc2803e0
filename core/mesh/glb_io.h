// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Binary glTF 2.0 (GLB).
//
// Read are all triangle primitives (list, strip, fan) of the default scene, or of all roots where
// there is none: POSITION, NORMAL, TEXCOORD_0, under the transforms of their nodes; a mirroring
// node turns its triangles over. Positions with the same bits become one vertex: glTF doubles
// vertices at every seam. A primitive's group is its material, else its mesh. Texture coordinates
// are turned to have their origin below left. Lines and points are passed over. Refused are
// external buffers, sparse accessors, compressed geometry and unknown required extensions. Skins,
// morph targets and images are not looked at.
//
// Errors   reading: kInvalidArgument, reason MALFORMED_FILE, naming the byte or the glTF element
//          writing: kResourceExhausted above the 4 GiB of a GLB
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_GLB_IO_H_
#define LATTICED_CORE_MESH_GLB_IO_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<PolygonMesh> ReadGlb(std::string_view bytes);

// One mesh on one node. Positions are float32 about the centre of the bounds, which is the node's
// translation: a mesh far from the origin keeps its precision. Every group is a primitive with a
// material of its name. Known units make that node the child of a root that turns and scales to
// glTF's own, metres and +y up, and are named in asset.extras as upAxis and metersPerUnit.
[[nodiscard]] absl::StatusOr<std::string> WriteGlb(const TriangleMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_GLB_IO_H_
