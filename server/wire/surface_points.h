// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of the surface, as clients name them, -> points of the rest world.
//
// Errors   kInvalidArgument with the path of the field
// Threads  pure function
#ifndef LATTICED_SERVER_WIRE_SURFACE_POINTS_H_
#define LATTICED_SERVER_WIRE_SURFACE_POINTS_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/weights/vertex_weights.h"
#include "core/mesh/polygon_mesh.h"
#include "latticed/v1/surface.pb.h"

namespace latticed {

// A point of the rest surface, and the normal of the source triangle there (not normalised).
struct RestPoint {
  Vec3d position;
  Vec3d normal;
  double weight = 1;  // with its gradient, where there are weights
  Vec3d weight_gradient;
};

// `weights` are the scene's, or null.
[[nodiscard]] absl::StatusOr<RestPoint> RestPointFromProto(const PolygonMesh& mesh,
                                                           const VertexWeights& weights,
                                                           const v1::SurfacePoint& point,
                                                           const std::string& field);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_SURFACE_POINTS_H_
