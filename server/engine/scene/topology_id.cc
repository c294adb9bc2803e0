// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/topology_id.h"

#include "core/base/sha256.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// 128 bits of the hash are enough for a name.
constexpr size_t kHashDigits = 32;
// Rises when a plan of the same mesh and structure gets another order of patches or corners: clients may keep the plan
// of an older server.
constexpr int kOrder = 2;

void Append(std::string& text, Vec3d v) { text += fmt::format("{:a},{:a},{:a};", v.x, v.y, v.z); }

void Append(std::string& text, const LatticeStructure& structure) {
  for (size_t axis = 0; axis < 3; ++axis) {
    text += fmt::format("{},{}:", structure.degree[axis], structure.size[axis]);
    for (const double knot : structure.knots[axis]) text += fmt::format("{:a},", knot);
    Append(text, structure.frame.edges[axis]);
  }
  Append(text, structure.frame.origin);
}

}  // namespace

std::string WeightedMeshId(std::string_view mesh_id, const VertexWeights& weights) {
  if (weights == nullptr) return std::string(mesh_id);
  const std::string_view bytes(reinterpret_cast<const char*>(weights->data()),
                               weights->size() * sizeof(float));
  return fmt::format("{}+{}", mesh_id, Sha256Hex(bytes));
}

std::string TopologyId(std::string_view mesh_id, const DeformPlan& plan, int segments) {
  std::string text = fmt::format("{};{};", kOrder, mesh_id);
  Append(text, plan.structure);
  for (const TurnedLattice& lattice : plan.turned) Append(text, lattice.structure);
  return fmt::format("{}-{}", Sha256Hex(text).substr(0, kHashDigits), segments);
}

}  // namespace latticed
