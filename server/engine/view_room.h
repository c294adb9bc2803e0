// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The host memory that a view may take: the chunks of as many snapshots as there may be, and the
// vertices where no device keeps them; then it has one slot of them. What chunks take is known once
// they are encoded, and what is reserved grows where that is more than was expected.
//
// Errors   kResourceExhausted OUT_OF_MEMORY
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_VIEW_ROOM_H_
#define LATTICED_SERVER_ENGINE_VIEW_ROOM_H_

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "core/backend.h"
#include "server/base/memory_budget.h"
#include "server/engine/snapshot.h"

namespace latticed {

// Draco's streams usually take a quarter of the bytes of their integers, or less.
inline constexpr uint64_t kIntegersPerDraco = 4;

// Of all vertices of a view; its chunks are no larger, but for their headers.
[[nodiscard]] uint64_t VertexBytes(const DeformPlan& plan, const ViewKey& key);

class ViewRoom {
 public:
  // Null: no limit.
  explicit ViewRoom(std::shared_ptr<MemoryBudget> budget) : budget_(std::move(budget)) {}

  // Changes what is reserved to what the view needs while its snapshots keep `held` bytes. Where that
  // is refused nothing changes.
  [[nodiscard]] absl::Status Make(const DeformTarget& target, const ViewKey& key, uint64_t held);
  uint64_t bytes() const { return reservation_.bytes(); }
  void Release() { reservation_.Release(); }

 private:
  const std::shared_ptr<MemoryBudget> budget_;
  MemoryReservation reservation_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_VIEW_ROOM_H_
