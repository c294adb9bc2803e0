// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The base of every reactor: a call is counted and logged from Begin to FinishCall, and its reactor is
// deleted when gRPC is done with it.
//
// Threads  as gRPC calls a reactor; Work runs on a worker
#ifndef LATTICED_SERVER_RPC_CALL_REACTOR_H_
#define LATTICED_SERVER_RPC_CALL_REACTOR_H_

#include <functional>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "core/base/catch_bad_alloc.h"
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"
#include "server/wire/edit_converters.h"
#include "server/wire/grpc_status.h"
#include "server/wire/message_bytes.h"

namespace latticed {

template <typename Reactor>
class CallReactor : public Reactor {
 public:
  void OnDone() override {
    Done();
    delete this;
  }

 protected:
  // Returns whether the call may go on. If not, it has been finished.
  bool Begin(ServerEnv& env, grpc::CallbackServerContext* context, const Rpc& rpc) {
    const absl::Status begun = BeginCall(env, context, rpc, call_);
    if (!begun.ok()) FinishCall(begun);
    return begun.ok();
  }

  // Called before and after each write of a stream.
  void BeginWrite() { call_.write->Begin(absl::Now()); }
  void EndWrite() { call_.write->End(); }
  // The call is done. Called by OnDone; gRPC's context of the call ends with it.
  void Done() { call_.write->Close(); }

  void FinishCall(const grpc::Status& status) {
    LogFinished(call_, status);
    BeginWrite();
    Reactor::Finish(status);
  }
  void FinishCall(const absl::Status& status) { FinishCall(ToGrpcStatus(status)); }

  // Takes the request out of `bytes` and runs `work` on a worker, then frees the request and gives the result to
  // `done` on the same worker. If the bytes are no such message, or there is no memory for the waiting
  // request, the call is finished. Called last in a constructor: the reactor may be deleted when this
  // returns.
  template <typename Request>
  void Work(ServerEnv& env, WorkerLanes::Lane lane, const grpc::ByteBuffer& bytes, Request& request,
            std::function<absl::Status()> work, std::function<void(absl::Status)> done) {
    if (absl::Status s = TakeMessage(bytes, &request); !s.ok()) return FinishCall(s);
    if constexpr (requires { request.scene(); }) NoteScene(call_, request.scene());
    auto room = AdmitRequest(env, call_, request);
    if (!room.ok()) return FinishCall(room.status());
    request_room_ = *std::move(room);
    if constexpr (requires { MayTakeLong(request); }) {
      // An edit waits until it is stored.
      if (MayTakeLong(request) || env.store != nullptr) lane = WorkerLanes::Lane::kLong;
    }
    if constexpr (requires { request.scene(); }) {
      if (env.IsAsleep(KeyFor(call_, request.scene()))) lane = WorkerLanes::Lane::kLong;
    }
    if constexpr (requires { request.mesh(); }) {
      if (env.meshes.IsAsleep(KeyFor(call_, request.mesh()))) lane = WorkerLanes::Lane::kLong;
    }
    env.Post(lane, *call_.account,
             [this, &request, work = std::move(work), done = std::move(done)] {
               absl::Status result = CheckCancelled(call_);
               if (result.ok()) result = CatchBadAlloc("the request", work);
               request = Request();  // frees its memory, which Clear would keep
               request_room_.Release();
               done(result);
             });
  }

  CallInfo call_;

 private:
  MemoryReservation request_room_;  // while the request waits
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_CALL_REACTOR_H_
