// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What each caller has of the server's limits. A caller is the name of a token or of a certificate, else an
// address. No caller gets more than its share of a limit, so the others always find some left.
//
//   share = --caller-share of a limit, at least 1
//   Callers of this machine without a name have no shares: there is nobody to be fair to.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORES_CALLERS_H_
#define LATTICED_SERVER_STORES_CALLERS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/engine/memory/memory_account.h"

namespace latticed {

// The limits of a server that callers share, in bytes.
struct SharedBudgets {
  uint64_t memory = 0;
  uint64_t requests = 0;  // that wait for a worker
  uint64_t replies = 0;   // that wait for their client
};

class CallerAccount {
 public:
  CallerAccount(double share, const SharedBudgets& budgets);

  // False for callers who may have all.
  bool has_share() const { return share_ < 1; }
  // The most that the caller may have of a limit on a number of things.
  [[nodiscard]] size_t ShareOf(size_t limit) const;
  // Counts a call. Returns false when the caller has made limits::kMaxCallsPerSecond within this second.
  [[nodiscard]] bool TakeCall(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  const MemoryAccountPtr memory, requests, replies;

 private:
  const double share_;
  Mutex mutex_;
  int64_t second_ ABSL_GUARDED_BY(mutex_) = 0;  // Unix time
  uint64_t calls_ ABSL_GUARDED_BY(mutex_) = 0;  // within second_
};

class Callers {
 public:
  // `share` is above 0, and at most 1, which means no shares.
  Callers(double share, const SharedBudgets& budgets) : share_(share), budgets_(budgets) {}

  // The account of a caller. `name` may be empty; `address` is as gRPC writes it, "ipv4:127.0.0.1:5000". An
  // address that a proxy has forwarded is not of this machine, whatever it is.
  [[nodiscard]] std::shared_ptr<CallerAccount> Of(const std::string& name,
                                                  const std::string& address,
                                                  bool is_forwarded = false)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets the accounts that nobody uses. Called once a second.
  void DropUnused() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const double share_;
  const SharedBudgets budgets_;
  Mutex mutex_;
  std::map<std::string, std::shared_ptr<CallerAccount>> accounts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORES_CALLERS_H_
