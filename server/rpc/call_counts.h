// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls by rpc and by how they ended, and refusals by reason. What clients can make up (unknown
// methods, words of their own) is in none of the names.
//
// Threads  safe, without locks
#ifndef LATTICED_SERVER_RPC_CALL_COUNTS_H_
#define LATTICED_SERVER_RPC_CALL_COUNTS_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <grpcpp/support/status.h>

#include "absl/time/time.h"
#include "latticed/v1/common.pb.h"
#include "server/base/duration_histogram.h"

namespace latticed {

inline constexpr size_t kStatusCodes = grpc::StatusCode::UNAUTHENTICATED + 1;  // OK is the first

// Of one rpc. Streams last as long as their client likes.
struct RpcCounts {
  std::atomic<uint64_t> started = 0;
  std::array<std::atomic<uint64_t>, kStatusCodes> finished{};
  DurationHistogram duration;
};

class CallCounts {
 public:
  // Every rpc of latticed.v1, as its descriptors have them.
  CallCounts();

  // Of "MeshService/UploadMesh"; null for a name that is no rpc.
  [[nodiscard]] RpcCounts* Find(std::string_view rpc);
  // A call or an edit was refused for that ErrorReason; none other counts.
  void NoteRefusal(std::string_view reason);

  // As ErrorInfo has it: "OUT_OF_MEMORY".
  [[nodiscard]] static std::string NameOf(v1::ErrorReason reason);

  const std::map<std::string, RpcCounts, std::less<>>& rpcs() const { return rpcs_; }
  uint64_t refusals(v1::ErrorReason reason) const {
    return refusals_[static_cast<size_t>(reason)].load();
  }

 private:
  std::map<std::string, RpcCounts, std::less<>> rpcs_;  // its keys never change
  std::array<std::atomic<uint64_t>, v1::ErrorReason_ARRAYSIZE> refusals_{};
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_CALL_COUNTS_H_
