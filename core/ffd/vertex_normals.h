// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rest normals for smooth shading: one unit normal per corner of the mesh.
//
//   It is the file's own normal if that has a length. Else it is the sum of the area vectors of the faces around the
//   position, where seams of UVs or normals do not count; else the face's own area vector; else +z.
//
// Errors   what `stop` returns
// Threads  pure function
#ifndef LATTICED_CORE_FFD_VERTEX_NORMALS_H_
#define LATTICED_CORE_FFD_VERTEX_NORMALS_H_

#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<std::vector<Vec3f>> UnitCornerNormals(const PolygonMesh& mesh,
                                                                   StopCheck stop = NeverStop);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_VERTEX_NORMALS_H_
