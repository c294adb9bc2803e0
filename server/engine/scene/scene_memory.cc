// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/scene_memory.h"

#include <algorithm>
#include <new>

#include "core/ffd/deform_plan.h"

namespace latticed {
namespace {

uint64_t PointsOf(const LatticeStructure& structure) {
  return static_cast<uint64_t>(structure.control_point_count());
}

}  // namespace

// Every corner beyond a face's second makes a triangle, and every triangle at least one patch.
uint64_t LeastPlanBytes(const PolygonMesh& mesh) {
  constexpr uint64_t kPatchBytes =
      sizeof(Patch) + sizeof(PatchSource) + sizeof(PlanEdge) + sizeof(PlanVertex) / 2;
  return (mesh.corner_count() - 2 * mesh.face_count()) * kPatchBytes;
}

void ProbeMemory(uint64_t bytes) { ::operator delete(::operator new(bytes)); }

uint64_t LatticeBytes(const LatticeStructure& structure) {
  constexpr uint64_t kCopies = 4;
  return kCopies * sizeof(Vec3d) * PointsOf(structure);
}

uint64_t LeastHistoryBytes(const LatticeStructure& structure) {
  // A step holds a point, its index and where the gesture found it (EditStep::MemoryBytes), the log a
  // point and its index.
  constexpr uint64_t kGesture = 28 + 80, kLog = 28;
  // A few editors, and whatever else a scene has but for its plan: labels, and the scene itself.
  constexpr uint64_t kScene = uint64_t{16} << 10;
  return kScene + (kGesture + kLog) * PointsOf(structure);
}

bool HistoryReservation::Hold(uint64_t bytes, const LatticeStructure& structure) {
  const uint64_t beyond = bytes - std::min(bytes, LeastHistoryBytes(structure));
  const uint64_t wanted = (beyond + kStepBytes - 1) / kStepBytes * kStepBytes;
  return wanted == reservation_.bytes() ||
         reservation_.TryResize("the scene's history", wanted).ok();
}

}  // namespace latticed
