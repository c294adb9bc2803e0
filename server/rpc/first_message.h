// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The wait for the first message of a stream that the client writes. Before it a stream has reserved
// nothing, so the wait has an end: a stream that never says what it wants must not hold its place.
//
//   Await -> Arrive, by the reader     what comes first decides, and the other does nothing
//         -> late, by an alarm
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
  // `late` ends the call, after which its object may be gone, with FAILED_PRECONDITION
  // STREAM_NOT_OPENED: the first message must be `what`, and none came in time.
  void Await(absl::Duration timeout, const char* what, std::function<void(absl::Status)> late);
  // The message is here, or none will come. False when it was too late: `late` runs, or has run. Those
  // after the first say what the first did.
  [[nodiscard]] bool Arrive();

 private:
  enum class State { kAwaited, kArrived, kLate };
  const std::shared_ptr<std::atomic<State>> state_ =  // outlives the stream, in the alarm
      std::make_shared<std::atomic<State>>(State::kAwaited);
  grpc::Alarm alarm_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_FIRST_MESSAGE_H_
