// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Names the layout of a view's points. The same mesh, weights, knots, frame and segments give the same name,
// in every scene and every run of the server: clients may cache what GetTopology says under it.
//
// Threads  pure function
#ifndef LATTICED_SERVER_ENGINE_SCENE_TOPOLOGY_ID_H_
#define LATTICED_SERVER_ENGINE_SCENE_TOPOLOGY_ID_H_

#include <string>
#include <string_view>

#include "core/backend.h"
#include "core/ffd/lattice.h"
#include "core/ffd/weights/vertex_weights.h"

namespace latticed {

// The segments that name the topology of a view: 0 for all views with a tolerance or without positions.
[[nodiscard]] inline int TopologySegments(const ViewSpec& spec) {
  return spec.tolerance > 0 || !HasPositions(spec) ? 0 : spec.segments;
}

// What TopologyId takes for the id of a mesh: the id alone, or with a hash of the scene's weights. Vertices of other weights may
// be other vertices of the plan, and then patches may have another order.
[[nodiscard]] std::string WeightedMeshId(std::string_view mesh_id, const VertexWeights& weights);

// 32 hex digits of a hash, a dash, and TopologySegments.
[[nodiscard]] std::string TopologyId(std::string_view mesh_id, const DeformPlan& plan,
                                     int segments);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_TOPOLOGY_ID_H_
