// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls that are made again while a server does not answer.
//
//   pause after failure n   min(100 ms 2ⁿ⁻¹, 1 s) · r, r uniform in [0.75, 1.25): at most 1.25 s
//
// A pause ends earlier when the channel has connected again. The factor r keeps the clients of a server that died from
// coming back all at once. It is not uniform in [0, 1], as it often is elsewhere: short pauses would only load a server
// that starts.
//
// Threads  MayRetry: any; Attempts: one at a time
#ifndef LATTICED_CLIENT_CPP_LIBRARY_RETRIES_ATTEMPTS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_RETRIES_ATTEMPTS_H_

#include <optional>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "client/cpp/library/retries/reachability.h"

namespace latticed::client {

// Whether another attempt may succeed: after UNAVAILABLE, CANCELLED (by a proxy), INTERNAL (a broken transport) and
// UNKNOWN (a proxy ended the stream without a status). Not after INTERNAL and UNKNOWN of a server that answered, nor
// where something else than a latticed is at the address, or the address or the TLS files cannot be used.
[[nodiscard]] bool MayRetry(const absl::Status& status);

// The failures in a row of one call or stream.
class Attempts {
 public:
  // `server` must outlive it.
  explicit Attempts(Reachability* server) : server_(server) {}

  // Called after a failure. Returns the pause before the next attempt; nullopt if another cannot help, or would begin
  // more than retry_for after the first failure.
  [[nodiscard]] std::optional<absl::Duration> PauseAfter(const absl::Status& failure);
  // Called after a success. The next failure is the first again.
  void Succeeded();

 private:
  Reachability* const server_;
  int failures_ = 0;
  absl::Time first_failure_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_RETRIES_ATTEMPTS_H_
