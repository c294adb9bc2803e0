// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Waits for the first message of a stream that the client writes, up to a time limit: a stream that never
// says what it wants must not keep its place.
//
//   Await -> Arrive, called by the reader     whichever comes first; the other then does nothing
//         -> late, called by an alarm
//
// Threads  Arrive is safe beside the alarm; Await comes before
#ifndef LATTICED_SERVER_RPC_FIRST_MESSAGE_H_
#define LATTICED_SERVER_RPC_FIRST_MESSAGE_H_

#include <atomic>
#include <functional>
#include <memory>

#include <grpcpp/alarm.h>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace latticed {

class FirstMessage {
 public:
  // `late` gets FAILED_PRECONDITION, reason STREAM_NOT_OPENED: the first message must be `what`, and none came
  // in time. It ends the call, whose object may then be deleted.
  void Await(absl::Duration timeout, const char* what, std::function<void(absl::Status)> late);
  // Called when the message has come, or none will come. Returns false when it is too late, because `late`
  // runs or has run. Later calls return what the first one did.
  [[nodiscard]] bool Arrive();

 private:
  enum class State { kAwaited, kArrived, kLate };
  const std::shared_ptr<std::atomic<State>> state_ =  // outlives the stream, in the alarm
      std::make_shared<std::atomic<State>>(State::kAwaited);
  grpc::Alarm alarm_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_FIRST_MESSAGE_H_
