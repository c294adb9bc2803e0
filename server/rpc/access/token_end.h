// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Ends a stream when the token that opened it ends: it has expired, or is that of a share that has ended.
//
// Threads  EndWith once; the alarm runs on a thread of gRPC, the end of a share where it is revoked
#ifndef LATTICED_SERVER_RPC_ACCESS_TOKEN_END_H_
#define LATTICED_SERVER_RPC_ACCESS_TOKEN_END_H_

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>

#include <grpcpp/alarm.h>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/base/auth/caller.h"

namespace latticed {

class SceneStream;  // server/rpc/scene_stream.h

// kUnauthenticated when the caller's token has ended.
[[nodiscard]] absl::Status CheckTokenTime(const Caller& caller, absl::Time now);

class TokenEnd {
 public:
  // The stream fails with kUnauthenticated when the caller's token ends, if it still exists.
  void EndWith(const Caller& caller, const std::weak_ptr<SceneStream>& stream);

 private:
  grpc::Alarm alarm_;  // its destructor cancels it
  std::optional<std::stop_callback<std::function<void()>>> share_end_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_ACCESS_TOKEN_END_H_
