// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The host memory that a scene takes besides its views: some from the start, with its plan, and for
// what it keeps of edits more, while the budget has it.
//
//   LeastPlanBytes     before the plan is made, which tells the rest
//   LatticeBytes       copies of the control points: initial, base and top of the undo steps, newest state
//   LeastHistoryBytes  a gesture that moves every control point, and how that is told to watchers: with
//                      so much from the start no edit needs to be refused
//
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_MEMORY_SCENE_ROOM_H_
#define LATTICED_SERVER_ENGINE_MEMORY_SCENE_ROOM_H_

#include <cstdint>
#include <memory>

#include "core/ffd/lattice.h"
#include "core/mesh/polygon_mesh.h"
#include "server/engine/memory/memory_budget.h"

namespace latticed {

[[nodiscard]] uint64_t LeastPlanBytes(const PolygonMesh& mesh);
// Throws std::bad_alloc where so much has no room: Abseil's tables, which MakePlan uses, do not survive
// an allocation that fails half-way.
void ProbeMemory(uint64_t bytes);
[[nodiscard]] uint64_t LatticeBytes(const LatticeStructure& structure);
[[nodiscard]] uint64_t LeastHistoryBytes(const LatticeStructure& structure);

class HistoryRoom {
 public:
  // Null: no limit.
  explicit HistoryRoom(std::shared_ptr<MemoryBudget> budget) : budget_(std::move(budget)) {}

  // Whether `bytes` of history have room. Asks the budget for what is beyond LeastHistoryBytes, a
  // step of kStepBytes at a time, and gives back what is wanted no more; where that is refused nothing
  // changes.
  [[nodiscard]] bool Make(uint64_t bytes, const LatticeStructure& structure);

 private:
  static constexpr uint64_t kStepBytes = uint64_t{16} << 10;

  const std::shared_ptr<MemoryBudget> budget_;
  MemoryReservation reservation_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_MEMORY_SCENE_ROOM_H_
