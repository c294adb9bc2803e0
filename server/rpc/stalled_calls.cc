// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/stalled_calls.h"

#include <grpc/grpc.h>

#include "fmt/format.h"
#include "server/base/telemetry.h"

namespace latticed {

void PendingWrite::Close() {
  const MutexLock lock(&mutex_);
  context_ = nullptr;
}

bool PendingWrite::CancelSince(absl::Time time) {
  if (since_ns_ > absl::ToUnixNanos(time)) return false;
  grpc_call* call = nullptr;
  {
    const MutexLock lock(&mutex_);
    if (context_ == nullptr) return false;
    call = context_->c_call();
    grpc_call_ref(call);
  }
  // Without the lock: this may run the call's callbacks.
  grpc_call_cancel_with_status(call, GRPC_STATUS_CANCELLED, "the client takes nothing", nullptr);
  grpc_call_unref(call);
  End();
  return true;
}

std::shared_ptr<PendingWrite> StalledCalls::Add(grpc::CallbackServerContext* context) {
  auto call = std::make_shared<PendingWrite>(context);
  const MutexLock lock(&mutex_);
  calls_.push_back(call);
  return call;
}

void StalledCalls::CancelSince(absl::Time time) {
  std::vector<std::shared_ptr<PendingWrite>> calls;
  {
    const MutexLock lock(&mutex_);
    std::erase_if(calls_, [&](const std::weak_ptr<PendingWrite>& weak) {
      auto call = weak.lock();
      if (call == nullptr) return true;
      calls.push_back(std::move(call));
      return false;
    });
  }
  size_t cancelled = 0;
  for (const auto& call : calls) {
    if (call->CancelSince(time)) ++cancelled;
  }
  if (cancelled == 0) return;
  LogEvent(spdlog::level::info, "calls were cancelled: their clients take nothing",
           {{"calls", fmt::to_string(cancelled)}});
}

}  // namespace latticed
