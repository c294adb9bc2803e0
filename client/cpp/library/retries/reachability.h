// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a client knows of its server: whether it answers, and since when others were told.
//
// Threads  any
#ifndef LATTICED_CLIENT_CPP_LIBRARY_RETRIES_REACHABILITY_H_
#define LATTICED_CLIENT_CPP_LIBRARY_RETRIES_REACHABILITY_H_

#include <functional>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "grpcpp/channel.h"

namespace latticed::client {

// How long a client tries to reach a server that does not answer.
inline constexpr absl::Duration kRetryFor = absl::Seconds(30);

// Called with the error when the client has failed twice in a row and tries again, and with OK when the server has
// answered again. Not called when the client gives up: the call returns the error. Must not call the client. May be
// called from any thread that uses the client, but from one at a time.
using ReachabilityObserver = std::function<void(const absl::Status&)>;

// What the calls and streams of a client know of its server.
class Reachability {
 public:
  Reachability(absl::Duration retry_for, ReachabilityObserver observer);

  absl::Duration retry_for() const { return retry_for_; }
  // Returns after the pause, or when the call's channel has connected again, or soon after stopped() holds. If the channel is
  // connected already, its server has refused the call, and the whole pause is waited for.
  //
  // To sleep would not do: gRPC handles the events of its sockets in threads that wait for calls or for the channel's
  // state, and otherwise every 5 s. A connection that came up in a sleep would be seen that late.
  static void Wait(grpc::Channel& channel, absl::Duration pause,
                   const std::function<bool()>& stopped);

  // Tells the observer that the client tries again after this error, unless it was told already.
  void Lost(const absl::Status& error);
  // Tells the observer that the server has answered, if it was told of an error.
  void Found();
  // The time of a call is over: the next error is told again.
  void GaveUp();

 private:
  const absl::Duration retry_for_;
  const ReachabilityObserver observer_;
  Mutex mutex_;
  bool lost_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_RETRIES_REACHABILITY_H_
