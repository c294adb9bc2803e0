// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Weights of a mesh's vertices: how much of the deformation each vertex takes.
//
//   x  -> x + w (F(x) - x)                         F the lattice's map; w is linear over each source triangle
//   J  = I + w (J_F - I) + (F(x) - x) grad(w)^T    grad(w) lies in the triangle's plane
//
// With weight 0 a vertex rests, with 1 it follows the lattice. Over a patch the surface has degree n + 1. Vertices at one
// position share a corner of the surface where their weights are equal; where they differ, the surface may come apart.
//
// Units    none: 0 to 1
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_WEIGHTS_VERTEX_WEIGHTS_H_
#define LATTICED_CORE_FFD_WEIGHTS_VERTEX_WEIGHTS_H_

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

// One weight per position of the mesh. Null: the mesh has no weights, and follows the lattice everywhere.
using VertexWeights = std::shared_ptr<const std::vector<float>>;

// A change of a scene's weights.
struct SetWeights {
  std::vector<uint32_t> indices;  // of vertices, none twice; empty: of all
  std::vector<float> values;  // one each; empty with no indices: the scene has no weights any more
};

// The weights after the change. `vertices` of the mesh; 0: not known. Null weights are all 1 where only some are set.
// kInvalidArgument naming `field` and values or indices.
[[nodiscard]] absl::StatusOr<VertexWeights> Changed(const VertexWeights& weights,
                                                    const SetWeights& change, size_t vertices,
                                                    std::string_view field);
// Whether both are none, or the same numbers.
[[nodiscard]] bool SameWeights(const VertexWeights& a, const VertexWeights& b);

// kInvalidArgument for another number of weights than of positions, and for a weight that is not from 0 to 1.
[[nodiscard]] absl::Status CheckVertexWeights(const PolygonMesh& mesh,
                                              std::span<const float> weights);

// The gradient of the linear function with these values at the corners of a triangle, in its plane. Zero where the
// triangle has no area, or is a billion times as long as high.
[[nodiscard]] Vec3d WeightGradient(const std::array<Vec3d, 3>& corners,
                                   const std::array<double, 3>& weights);

// Turns a deformed point and its Jacobian, as columns d(deformed)/d(x, y, z), into those with a weight. `rest` is the point
// at rest, `gradient` that of the weight there.
void Weigh(Vec3d rest, double weight, Vec3d gradient, Vec3d& position,
           std::array<Vec3d, 3>& jacobian);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_WEIGHTS_VERTEX_WEIGHTS_H_
