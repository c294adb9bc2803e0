// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one caller has reserved of a MemoryBudget, and the most that it may. A reservation names the account that
// it is charged to. An account belongs to one budget.
//
// Threads  safe; MemoryBudget changes it under its own lock
#ifndef LATTICED_SERVER_ENGINE_MEMORY_MEMORY_ACCOUNT_H_
#define LATTICED_SERVER_ENGINE_MEMORY_MEMORY_ACCOUNT_H_

#include <atomic>
#include <cstdint>
#include <memory>

namespace latticed {

class MemoryAccount {
 public:
  explicit MemoryAccount(uint64_t most_bytes) : most_(most_bytes) {}

  uint64_t most_bytes() const { return most_; }
  uint64_t used_bytes() const { return used_.load(); }

 private:
  friend class MemoryBudget;
  const uint64_t most_;
  std::atomic<uint64_t> used_ = 0;
  std::atomic<int64_t> nothing_until_ns_ = 0;  // until then, nothing more can be evicted
};

// Null: the caller may take whatever is free.
using MemoryAccountPtr = std::shared_ptr<MemoryAccount>;

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_MEMORY_MEMORY_ACCOUNT_H_
