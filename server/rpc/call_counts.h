// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Counts calls by rpc and by status, and refusals by reason and, for the log, by address. No name contains what
// clients can choose (unknown methods, their own words).
//
// Threads  safe
#ifndef LATTICED_SERVER_RPC_CALL_COUNTS_H_
#define LATTICED_SERVER_RPC_CALL_COUNTS_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <grpcpp/support/status.h>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/base/duration_histogram.h"
#include "server/base/refusal_log.h"

namespace latticed {

inline constexpr size_t kStatusCodes = grpc::StatusCode::UNAUTHENTICATED + 1;  // OK is the first

// The counts of one rpc. Durations of streams are as long as their clients choose.
struct RpcCounts {
  std::atomic<uint64_t> started = 0;
  std::array<std::atomic<uint64_t>, kStatusCodes> finished{};
  DurationHistogram duration;
};

class CallCounts {
 public:
  // With the rpcs of all services: a counter that appears with its first call hides that call from rates.
  CallCounts();

  // The counts of an Rpc's name, such as "MeshService/UploadMesh".
  [[nodiscard]] RpcCounts& Of(std::string_view rpc) ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    return rpcs_[std::string(rpc)];
  }
  // A call or an edit was refused for that ErrorReason; one without a reason does not count.
  void NoteRefusal(const std::string& reason) ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    if (!reason.empty()) ++refusals_[reason];
  }

  // By name, with those that were never called.
  [[nodiscard]] std::vector<std::pair<std::string, const RpcCounts*>> rpcs() const
      ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    std::vector<std::pair<std::string, const RpcCounts*>> all;
    for (const auto& [name, counts] : rpcs_) all.emplace_back(name, &counts);
    return all;
  }
  [[nodiscard]] std::map<std::string, uint64_t> refusals() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    return refusals_;
  }
  [[nodiscard]] RefusalLog& refusal_log() { return refusal_log_; }

 private:
  mutable Mutex mutex_;
  std::map<std::string, RpcCounts> rpcs_ ABSL_GUARDED_BY(mutex_);  // whose addresses stay
  // OUT_OF_MEMORY is shown from the start: operators watch it.
  std::map<std::string, uint64_t> refusals_ ABSL_GUARDED_BY(mutex_) = {{"OUT_OF_MEMORY", 0}};
  RefusalLog refusal_log_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_CALL_COUNTS_H_
