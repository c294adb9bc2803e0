// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/farewell.h"

#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "latticed/v1/event.pb.h"
#include "server/store/store_errors.h"
#include "server/wire/grpc_status.h"
#include "server/wire/time_converters.h"
#include "server/wire/wire_buffers.h"

namespace latticed {
namespace {

// How long a client has to half-close: a round trip to the other side of the earth, and more.
constexpr absl::Duration kFarewellTime = absl::Seconds(1);
// How long a client should wait after goaway, which is sent after the drain delay. By then another server, or
// the restarted one, takes the call.
constexpr absl::Duration kRestartTime = absl::Seconds(1);

}  // namespace

grpc::ByteBuffer DrainMessage(bool moves) {
  v1::SceneEvent event;
  v1::Goaway& goaway = *event.mutable_goaway();
  goaway.set_reason(moves ? v1::GOAWAY_REASON_MOVED : v1::GOAWAY_REASON_DRAINING);
  if (!moves) SetDuration(kRestartTime, *goaway.mutable_retry_after());
  return EncodeEvent(event);
}

const grpc::ByteBuffer* Farewell::Begin(const grpc::Status& status) {
  v1::SceneEvent event;
  v1::Goaway& goaway = *event.mutable_goaway();
  if (ReasonOf(status) == error::kSceneMovedReason) goaway.set_reason(v1::GOAWAY_REASON_MOVED);
  *goaway.mutable_status() = ToRpcStatus(status);
  message_ = EncodeEvent(event);
  status_ = status;
  begun_ = true;
  return &message_;
}

bool Farewell::Written(bool ok, std::function<void()> late) {
  const MutexLock lock(&mutex_);
  written_ = true;
  if (!ok || over_) return TakeEnd();
  alarm_.Set(absl::ToChronoTime(absl::Now() + kFarewellTime),
             [late = std::move(late)](bool expired) {
               if (expired) late();
             });
  return false;
}

bool Farewell::Over() {
  const MutexLock lock(&mutex_);
  over_ = true;
  return written_ && TakeEnd();
}

bool Farewell::TakeEnd() {
  alarm_.Cancel();
  return !std::exchange(ended_, true);
}

}  // namespace latticed
