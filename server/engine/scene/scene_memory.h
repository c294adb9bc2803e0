// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The host memory that a scene takes besides its views.
//
//   LeastPlanBytes     before the plan is made, which tells the rest
//   LatticeBytes       copies of the control points: initial, base and top of the undo steps, newest state
//   LeastHistoryBytes  a gesture that moves every control point, and its record for watchers. Reserved
//                      from the start, so that no edit is refused for want of them
//
// Threads  pure functions; a HistoryReservation is guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_SCENE_SCENE_MEMORY_H_
#define LATTICED_SERVER_ENGINE_SCENE_SCENE_MEMORY_H_

#include <cstdint>
#include <memory>
#include <utility>

#include "core/mesh/polygon_mesh.h"
#include "server/engine/lattices/scene_lattice.h"
#include "server/engine/memory/memory_budget.h"

namespace latticed {

[[nodiscard]] uint64_t LeastPlanBytes(const PolygonMesh& mesh);
// Throws std::bad_alloc where so many bytes cannot be allocated: Abseil's tables, which MakePlan uses,
// do not survive an allocation that fails half-way.
void ProbeMemory(uint64_t bytes);
// Control points, maps to those of the plan, and these in the newest state and in one that is drawn. Where nothing goes on
// outside a lone lattice, there are none at strength 1, but an edit may set another one.
[[nodiscard]] uint64_t LatticeBytes(const SceneLattices& lattices);
[[nodiscard]] uint64_t LeastHistoryBytes(const SceneLattices& lattices);

// Memory for undo steps and the log of edits beyond LeastHistoryBytes.
class HistoryReservation {
 public:
  explicit HistoryReservation(MemoryReservation empty) : reservation_(std::move(empty)) {}

  // Reserves for `bytes` of history, in steps of kStepBytes, and evicts nothing. False where the
  // budget has no more; then nothing changes.
  [[nodiscard]] bool Hold(uint64_t bytes, const SceneLattices& lattices);

 private:
  static constexpr uint64_t kStepBytes = uint64_t{16} << 10;

  MemoryReservation reservation_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_SCENE_MEMORY_H_
