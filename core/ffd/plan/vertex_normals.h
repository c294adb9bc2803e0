// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rest normals for smooth shading: one unit normal per corner of the mesh.
//
//   Without a crease angle, a corner whose file has a normal with a length keeps it. All other corners get the sum of
//   the area vectors of the faces around their position that one reaches from the corner's face across smooth edges;
//   if the sum is zero, the face's own area vector; else +z.
//
//   An edge is smooth if the faces at it meet at the crease angle or less. Edges are identified by position, so that
//   seams of UVs or normals do not count. An edge at a face without area is not smooth. Of more than four faces at an
//   edge, each is compared with the next three in the file.
//
// Units    degrees; the angle between two faces is that of their area vectors, 0 where they are coplanar
// Errors   what `stop` returns
// Threads  pure function
#ifndef LATTICED_CORE_FFD_PLAN_VERTEX_NORMALS_H_
#define LATTICED_CORE_FFD_PLAN_VERTEX_NORMALS_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

inline constexpr double kDefaultCreaseAngle = 30;

// `crease_angle`: 0 to 180; nothing: the file's normals, and kDefaultCreaseAngle where it has none.
[[nodiscard]] absl::StatusOr<std::vector<Vec3f>> UnitCornerNormals(
    const PolygonMesh& mesh, std::optional<double> crease_angle, StopCheck stop = NeverStop);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_VERTEX_NORMALS_H_
