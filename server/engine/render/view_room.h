// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The host memory that a view may take: the chunks of as many snapshots as there may be, and its
// slots: the vertices of one where no device keeps them, else what is staged for copies, pinned. What
// chunks and staging take is known once they were encoded, and what is reserved grows where that is
// more than was expected.
//
// Errors   kResourceExhausted OUT_OF_MEMORY
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_RENDER_VIEW_ROOM_H_
#define LATTICED_SERVER_ENGINE_RENDER_VIEW_ROOM_H_

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "core/backend.h"
#include "server/engine/memory/memory_budget.h"
#include "server/engine/render/snapshot.h"

namespace latticed {

// Draco's streams usually take a quarter of the bytes of their integers, or less.
inline constexpr uint64_t kIntegersPerDraco = 4;

// Of all vertices of a view; its chunks are no larger, but for their headers.
[[nodiscard]] uint64_t VertexBytes(const DeformPlan& plan, const ViewKey& key);

class ViewRoom {
 public:
  // Null: no limit.
  explicit ViewRoom(std::shared_ptr<MemoryBudget> budget) : budget_(std::move(budget)) {}

  // What a view keeps on the host, in bytes.
  struct Kept {
    uint64_t slots = 0;
    uint64_t chunks = 0;
  };
  // Changes what is reserved to what the view needs while it keeps so much, at least what is expected
  // of it. Where that is refused nothing changes.
  [[nodiscard]] absl::Status Make(const DeformTarget& target, const ViewKey& key, const Kept& kept);
  uint64_t bytes() const { return reservation_.bytes(); }
  void Release() { reservation_.Release(); }

 private:
  const std::shared_ptr<MemoryBudget> budget_;
  MemoryReservation reservation_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_VIEW_ROOM_H_
