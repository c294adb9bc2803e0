// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What every rpc does first and last: it finds out who calls, checks the role, takes the request id; and it
// counts and logs the status. call_reactor.h calls both.
#ifndef LATTICED_SERVER_RPC_CALL_H_
#define LATTICED_SERVER_RPC_CALL_H_

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "google/protobuf/message.h"
#include "server/base/auth/authenticator.h"
#include "server/engine/memory/memory_budget.h"

namespace latticed {

class CallCounts;     // server/rpc/call_counts.h
class CallerAccount;  // server/stores/callers.h
class PendingWrite;   // server/rpc/stalled_calls.h
struct ServerEnv;

// Edits and presence in other calls are checked as ApplyEdits is.
inline constexpr Rpc kApplyEditsRpc{"SceneService/ApplyEdits", Role::kEdit, kForShares};

struct CallInfo {
  Rpc rpc;
  Caller caller;                           // who, and with which role
  std::shared_ptr<CallerAccount> account;  // the caller's; null before BeginCall admits
  std::string request_id;                  // the client's if it is valid, else 16 random hex digits
  std::string traceparent;                 // W3C, empty if absent or malformed
  std::string peer;                        // "ipv4:127.0.0.1:5000": the other end of the socket
  bool is_forwarded = false;               // a trusted proxy named the peer
  bool is_proxied = false;                 // the call came through a proxy, as HTTP/2
  std::string scene;  // the scene of the call, if metadata or the request name one
  absl::Time start_time;
  std::chrono::steady_clock::time_point arrival;
  grpc::CallbackServerContext* context = nullptr;  // alive until the rpc is finished
  CallCounts* counts = nullptr;                    // of the server
  std::shared_ptr<PendingWrite> write;             // what the client is to take
};

// Reads metadata, puts latticed-request-id and latticed-node into the reply's metadata (initial,
// and trailing, since a refusal has only that in some clients), checks token and role.
// Fills `call`, also on errors, which the caller ends the call with.
// kUnauthenticated, kPermissionDenied; kUnavailable, reason DRAINING; kResourceExhausted, reason LIMIT_EXCEEDED,
// for too many calls, or too many wrong tokens.
[[nodiscard]] absl::Status BeginCall(ServerEnv& env, grpc::CallbackServerContext* context,
                                     const Rpc& rpc, CallInfo& call);

// kUnavailable, reason DRAINING, once the server drains.
[[nodiscard]] absl::Status CheckDraining(const ServerEnv& env);

// The scene that a request names, for the log. Empty when it is no id: it could be as long as a message.
void NoteScene(CallInfo& call, const std::string& scene);

// Counts the end of a call and logs it: faults of the server as errors, refusals as info, the rest
// at debug. Many refusals of one kind are summed up: LogRefusalSums tells them.
void LogFinished(const CallInfo& call, const grpc::Status& status);

// Logs the refusals that were only counted, of periods that have ended by `now`. Called once a second.
void LogRefusalSums(CallCounts& counts, absl::Time now);

// Puts latticed-owner into the reply's metadata: the server that has the scene of the call, as proxies know it. It is this
// one unless `found`, the scene's status, names another. Nothing where no servers share a store.
void NoteOwner(const ServerEnv& env, const CallInfo& call, const absl::Status& found);

// The metadata `latticed-scene`, where set, must name the scene of the body. kInvalidArgument.
[[nodiscard]] absl::Status CheckSceneMetadata(const CallInfo& call, std::string_view scene_id);

// Long work asks whether the caller still waits: OK, kDeadlineExceeded or kCancelled.
[[nodiscard]] absl::Status CheckCancelled(const CallInfo& call);

// Room for a parsed request while it waits for a worker. kResourceExhausted OUT_OF_MEMORY.
[[nodiscard]] absl::StatusOr<MemoryReservation> AdmitRequest(
    const ServerEnv& env, const CallInfo& call, const google::protobuf::Message& request);

// As a message and as its bytes.
[[nodiscard]] uint64_t ReplyBytes(const google::protobuf::Message& reply);

// Memory for what a call keeps until its client has taken the reply. A client that does not read keeps the
// message, and gRPC's copy of its bytes, in memory. All such replies share a budget beside --memory, so that
// they take nothing from scenes.
//
// Empty at first. Destroyed when the call is done. One thread at a time.
class ReplyRoom {
 public:
  // After BeginCall.
  void Open(const ServerEnv& env, const CallInfo& call);

  // Grows to `bytes`, if that is more than it has. Replies of up to limits::kSmallReplyBytes need no room: a
  // server whose replies nobody takes still answers probes, and requests that free memory.
  // kResourceExhausted, reason OUT_OF_MEMORY, changes nothing.
  [[nodiscard]] absl::Status Hold(uint64_t bytes);

 private:
  MemoryReservation room_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_CALL_H_
