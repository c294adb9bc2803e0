// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The one admission of memory: a limit, reservations under it, and eviction when it is reached.
//
//   Reserve(what, bytes) -> fits: a reservation, which gives the bytes back when it is destroyed
//                           does not fit: evict what can be made again, once enough can be freed,
//                           and reserve; else kResourceExhausted with asked and free bytes
//                           an account (memory_account.h) has its share used up: the same, but only scenes
//                           with views that are charged to it are evicted
//   Admit(call)          the same for a call that a device may refuse for its own memory
//
// --memory is the limit of one budget: uploads, meshes, scenes, views, streams and exports ask it
// before they allocate.
//
// Errors   kResourceExhausted, reason OUT_OF_MEMORY
// Threads  safe; a reservation belongs to one thread at a time. The evictor runs on the thread that
//          asks, with no lock of the budget held.
#ifndef LATTICED_SERVER_ENGINE_MEMORY_MEMORY_BUDGET_H_
#define LATTICED_SERVER_ENGINE_MEMORY_MEMORY_BUDGET_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/engine/memory/memory_account.h"

namespace latticed {

class MemoryBudget;

// What was missing when a request was refused.
struct MemoryShortage {
  uint64_t bytes = 0;         // missing bytes; 0: not known
  std::optional<int> device;  // the device that lacks them; nullopt: the host
  MemoryAccountPtr account;   // whose share lacks them; null: the budget's limit
};

// Reserved bytes of a budget, which it keeps alive; or empty.
class MemoryReservation {
 public:
  MemoryReservation() = default;
  MemoryReservation(MemoryReservation&& other) noexcept;
  MemoryReservation& operator=(MemoryReservation&& other) noexcept;
  ~MemoryReservation() { Release(); }

  // Changes the reservation to `bytes`. Fewer bytes are always granted; more are granted as by Reserve. A
  // refusal changes nothing. An empty reservation has no budget and no limit.
  [[nodiscard]] absl::Status Resize(std::string_view what, uint64_t bytes);
  // The same, but evicts nothing.
  [[nodiscard]] absl::Status TryResize(std::string_view what, uint64_t bytes);
  void Release();
  uint64_t bytes() const { return bytes_; }
  const MemoryAccountPtr& account() const { return account_; }

 private:
  friend class MemoryBudget;
  MemoryReservation(std::shared_ptr<MemoryBudget> budget, MemoryAccountPtr account);

  std::shared_ptr<MemoryBudget> budget_;
  MemoryAccountPtr account_;  // may be null
  uint64_t bytes_ = 0;
};

class MemoryBudget : public std::enable_shared_from_this<MemoryBudget> {
 public:
  // Frees the missing bytes, or nothing when fewer can be freed. Returns whether it freed any.
  using Evictor = std::function<bool(const MemoryShortage&)>;

  explicit MemoryBudget(uint64_t bytes) : total_(bytes) {}

  // With null nothing can be evicted. The caller sets null again before what the evictor uses is
  // destroyed.
  void SetEvictor(Evictor evictor) ABSL_LOCKS_EXCLUDED(mutex_);

  [[nodiscard]] absl::StatusOr<MemoryReservation> Reserve(std::string_view what, uint64_t bytes,
                                                          MemoryAccountPtr account = nullptr)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Reserves working memory that all share and nobody gives back. Of all calls, the one that asks for the
  // most counts.
  [[nodiscard]] absl::Status KeepAtLeast(std::string_view what, uint64_t bytes)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Runs `call`, which returns a Status or StatusOr. Runs it again while it is refused with
  // OUT_OF_MEMORY and something was evicted.
  // `account` is the one that the call's reservations name.
  template <typename Call>
  auto Admit(Call call, const MemoryAccountPtr& account = nullptr) -> decltype(call()) {
    while (true) {
      auto answer = call();
      const std::optional<MemoryShortage> shortage = ShortageOf(StatusOf(answer), account);
      if (!shortage.has_value() || !Evict(*shortage)) return answer;
    }
  }

  uint64_t total_bytes() const { return total_; }
  uint64_t used_bytes() const ABSL_LOCKS_EXCLUDED(mutex_);
  uint64_t free_bytes() const {
    const uint64_t used = used_bytes();
    return total_ > used ? total_ - used : 0;
  }
  uint64_t kept_bytes() const ABSL_LOCKS_EXCLUDED(mutex_);  // of KeepAtLeast; part of used_bytes

 private:
  friend class MemoryReservation;
  static absl::Status StatusOf(const absl::Status& status) { return status; }
  template <typename T>
  static absl::Status StatusOf(const absl::StatusOr<T>& answer) {
    return answer.status();
  }
  [[nodiscard]] static std::optional<MemoryShortage> ShortageOf(const absl::Status& status,
                                                                const MemoryAccountPtr& account);
  bool Evict(const MemoryShortage& shortage) ABSL_LOCKS_EXCLUDED(mutex_);
  // Gives back `before` and takes `after` at once.
  [[nodiscard]] absl::Status Exchange(std::string_view what, MemoryAccount* account,
                                      uint64_t before, uint64_t after) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::Status ExchangeLocked(std::string_view what, MemoryAccount* account,
                                            uint64_t before, uint64_t after)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const uint64_t total_;
  mutable Mutex mutex_;
  uint64_t used_ ABSL_GUARDED_BY(mutex_) = 0, kept_ ABSL_GUARDED_BY(mutex_) = 0;
  Evictor evictor_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_MEMORY_MEMORY_BUDGET_H_
