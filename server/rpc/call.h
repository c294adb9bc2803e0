// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What every rpc does first and last: who calls, may they, under which request id; and the answer's
// status. call_reactor.h does both.
#ifndef LATTICED_SERVER_RPC_CALL_H_
#define LATTICED_SERVER_RPC_CALL_H_

#include <chrono>
#include <string>
#include <string_view>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "google/protobuf/message.h"
#include "server/base/auth.h"
#include "server/engine/memory/memory_budget.h"

namespace latticed {

class CallCounts;  // server/rpc/call_counts.h
struct ServerEnv;

// Edits and presence in other calls are checked as ApplyEdits is.
inline constexpr Rpc kApplyEditsRpc{"SceneService/ApplyEdits", Role::kEdit};

struct CallInfo {
  Rpc rpc;
  Caller caller;            // who, and with which role
  std::string request_id;   // the client's where it is sane, else 16 random hex digits
  std::string traceparent;  // W3C, empty if absent or malformed
  std::string peer;         // "ipv4:127.0.0.1:5000": who is at the other end of the socket
  std::string scene;        // that the call is about, as far as is known: metadata, or the request
  absl::Time start_time;
  std::chrono::steady_clock::time_point arrival;
  grpc::CallbackServerContext* context = nullptr;  // alive until the rpc is finished
  CallCounts* counts = nullptr;                    // of the server
};

// Reads metadata, puts latticed-request-id and latticed-node into the reply's metadata (initial,
// and trailing, since a refusal has only that in some clients), checks token and role.
// kUnauthenticated, kPermissionDenied; kUnavailable, reason DRAINING.
[[nodiscard]] absl::StatusOr<CallInfo> BeginCall(const ServerEnv& env,
                                                 grpc::CallbackServerContext* context,
                                                 const Rpc& rpc);

// The scene that a request names, for the log: unless it is no id, as long as a message may be.
void NoteScene(CallInfo& call, const std::string& scene);

// Counts the end of a call and logs it: faults of the server as errors, refusals as info, the rest
// at debug.
void LogFinished(const CallInfo& call, const grpc::Status& status);

// The metadata `latticed-scene`, where set, must name the scene of the body. kInvalidArgument.
[[nodiscard]] absl::Status CheckSceneMetadata(const CallInfo& call, std::string_view scene_id);

// Whether the caller still waits, for long work to ask: kDeadlineExceeded, kCancelled.
[[nodiscard]] absl::Status CheckCancelled(const CallInfo& call);

// Frees what a message of gRPC's holds, once nobody reads it any more: gRPC keeps it until its call has
// ended, which is as late as the client likes.
void FreeMessage(const google::protobuf::Message& message);
void FreeMessage(const grpc::ByteBuffer& message);

// Room for a parsed request while it waits for a worker. kResourceExhausted OUT_OF_MEMORY.
[[nodiscard]] absl::StatusOr<MemoryReservation> AdmitRequest(
    const ServerEnv& env, const google::protobuf::Message& request);

// As a message and as its bytes.
[[nodiscard]] uint64_t ReplyBytes(const google::protobuf::Message& reply);

// Room for what a call keeps until its client has taken the reply: a client that does not read, or
// whose HTTP/2 window is shut, holds the message and gRPC's copy of its bytes. All such replies
// together have a budget of their own, beside --memory, so that they are in the way of no scene.
//
// Empty at first. Destroyed when the call is done. One thread at a time.
class ReplyRoom {
 public:
  explicit ReplyRoom(const ServerEnv& env);

  // For `bytes` in all, where that is more than it has. limits::kSmallReplyBytes need no room: so a
  // server whose replies nobody takes still answers who asks how it is, or frees memory.
  // kResourceExhausted OUT_OF_MEMORY, and nothing changes.
  [[nodiscard]] absl::Status Hold(uint64_t bytes);

 private:
  MemoryReservation room_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_CALL_H_
