// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bytes of host memory that uploads, meshes, scenes, views, streams and exports may take
// together: --memory. Whatever wants some asks before it allocates, and gives back when it is destroyed.
//
// Threads  safe; a reservation belongs to one thread at a time
#ifndef LATTICED_SERVER_ENGINE_MEMORY_MEMORY_BUDGET_H_
#define LATTICED_SERVER_ENGINE_MEMORY_MEMORY_BUDGET_H_

#include <cstdint>
#include <memory>
#include <mutex>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

class MemoryBudget;

// Empty, or bytes of a budget, which it keeps alive.
class MemoryReservation {
 public:
  MemoryReservation() = default;
  MemoryReservation(MemoryReservation&& other) noexcept;
  MemoryReservation& operator=(MemoryReservation&& other) noexcept;
  ~MemoryReservation() { Release(); }

  // To `bytes` in all. Less is always granted; more as by Reserve, and where it is refused nothing
  // changes. An empty reservation grows without a limit.
  [[nodiscard]] absl::Status Resize(std::string_view what, uint64_t bytes);
  void Release();
  uint64_t bytes() const { return bytes_; }

 private:
  friend class MemoryBudget;
  MemoryReservation(std::shared_ptr<MemoryBudget> budget, uint64_t bytes);

  std::shared_ptr<MemoryBudget> budget_;
  uint64_t bytes_ = 0;
};

class MemoryBudget : public std::enable_shared_from_this<MemoryBudget> {
 public:
  explicit MemoryBudget(uint64_t bytes) : total_(bytes) {}

  // kResourceExhausted OUT_OF_MEMORY: `what` needs so many bytes, so many are free.
  [[nodiscard]] absl::StatusOr<MemoryReservation> Reserve(std::string_view what, uint64_t bytes);

  // For working memory that is shared by all and kept: `bytes` in all, or what an earlier call asked
  // for where that is more. Never given back. kResourceExhausted as Reserve.
  [[nodiscard]] absl::Status KeepAtLeast(std::string_view what, uint64_t bytes);

  uint64_t total_bytes() const { return total_; }
  uint64_t used_bytes() const;
  uint64_t kept_bytes() const;  // of the used ones

 private:
  friend class MemoryReservation;
  // Gives back `before` and takes `after` at once.
  [[nodiscard]] absl::Status Exchange(std::string_view what, uint64_t before, uint64_t after);
  [[nodiscard]] absl::Status ExchangeLocked(std::string_view what, uint64_t before, uint64_t after);

  const uint64_t total_;
  mutable std::mutex mutex_;
  uint64_t used_ = 0, kept_ = 0;  // guarded by mutex_
};

// Of `budget`, or an empty reservation where there is none.
[[nodiscard]] absl::StatusOr<MemoryReservation> Reserve(const std::shared_ptr<MemoryBudget>& budget,
                                                        std::string_view what, uint64_t bytes);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_MEMORY_MEMORY_BUDGET_H_
