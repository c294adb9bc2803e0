// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/scene_memory.h"

#include <algorithm>
#include <new>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {
namespace {

uint64_t PointsOf(const LatticeStructure& structure) {
  return static_cast<uint64_t>(structure.control_point_count());
}

}  // namespace

// A face of n corners makes n - 2 triangles, and every triangle makes at least one patch.
uint64_t LeastPlanBytes(const PolygonMesh& mesh) {
  constexpr uint64_t kPatchBytes =
      sizeof(Patch) + sizeof(PatchSource) + sizeof(PlanEdge) + sizeof(PlanVertex) / 2;
  return (mesh.corner_count() - 2 * mesh.face_count()) * kPatchBytes;
}

void ProbeMemory(uint64_t bytes) { ::operator delete(::operator new(bytes)); }

uint64_t LatticeBytes(const SceneLattices& lattices) {
  constexpr uint64_t kCopies = 4;  // of the control points of a lattice
  const uint64_t planned = lattices[0].map->planned_count();
  uint64_t points = 2 * planned, bytes = 0;
  for (const SceneLattice& lattice : lattices) {
    const OutsideMap& map = *lattice.map;
    // Also the rest points of both, and in a scene of several what this one moves.
    points += (kCopies + 1) * PointsOf(map.structure()) + (lattices.size() == 1 ? 1 : 2) * planned;
    for (size_t axis = 0; axis < 3; ++axis) {
      bytes += map.rows(axis).size() * sizeof(OutsideMap::Row);
    }
  }
  return bytes + points * sizeof(Vec3d);
}

uint64_t LeastHistoryBytes(const SceneLattices& lattices) {
  // Bytes per control point. An undo step holds the point, its index, and a map node with its position before
  // the gesture (EditStep::MemoryBytes). The log holds the point and its index.
  constexpr uint64_t kGesture = 28 + 80, kLog = 28;
  // Bytes for all that a scene has besides its plan: a few editors, its labels, and the object itself.
  constexpr uint64_t kScene = uint64_t{16} << 10;
  uint64_t bytes = kScene;
  for (const SceneLattice& lattice : lattices) {
    bytes += (kGesture + kLog) * PointsOf(lattice.structure());
  }
  return bytes;
}

bool HistoryReservation::Hold(uint64_t bytes, const SceneLattices& lattices) {
  const uint64_t beyond = bytes - std::min(bytes, LeastHistoryBytes(lattices));
  const uint64_t wanted = (beyond + kStepBytes - 1) / kStepBytes * kStepBytes;
  return wanted == reservation_.bytes() ||
         reservation_.TryResize("the scene's history", wanted).ok();
}

}  // namespace latticed
