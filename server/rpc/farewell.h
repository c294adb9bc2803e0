// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The end of a stream with an error, for a client behind a proxy. Proxies such as HAProxy 2.6 replace the status of a
// call that ends before its client has half-closed. So the client is told in a message, and the call ends when it has
// half-closed, is gone, or has had a second.
//
//   Begin -> the message is written: Written -> Over, by whichever comes first
//
// Threads  safe; Begin comes first, once
#ifndef LATTICED_SERVER_RPC_FAREWELL_H_
#define LATTICED_SERVER_RPC_FAREWELL_H_

#include <grpcpp/alarm.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <atomic>
#include <functional>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace latticed {

// The goaway of a server that drains. `moves`: another server has the scene as soon as it is asked.
[[nodiscard]] grpc::ByteBuffer DrainMessage(bool moves);

class Farewell {
 public:
  // Returns the message to write: a goaway with the status. It lives as long as this.
  [[nodiscard]] const grpc::ByteBuffer* Begin(const grpc::Status& status);
  bool begun() const { return begun_; }
  // With which the call ends, once begun.
  const grpc::Status& status() const { return status_; }

  // The message is written, or could not be. Returns whether the call is to end now. If not, `late` is called after a
  // second; it must not keep this alive.
  [[nodiscard]] bool Written(bool ok, std::function<void()> late) ABSL_LOCKS_EXCLUDED(mutex_);
  // The client has half-closed, is gone, or is late. Returns whether the call is to end now. At most one call of Written
  // and Over returns true.
  [[nodiscard]] bool Over() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  bool TakeEnd() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  std::atomic<bool> begun_ = false;
  grpc::Status status_;
  grpc::ByteBuffer message_;
  Mutex mutex_;
  grpc::Alarm alarm_ ABSL_GUARDED_BY(mutex_);
  bool written_ ABSL_GUARDED_BY(mutex_) = false;
  bool over_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_FAREWELL_H_
