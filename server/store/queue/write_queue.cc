// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/queue/write_queue.h"

#include <utility>

#include "core/base/status_macros.h"
#include "server/store/store_errors.h"

namespace latticed {

void WriteQueue::Put(Write write) {
  MutexLock lock(&mutex_);
  unanswered_bytes_ += write.bytes.size();
  waiting_.push_back(std::move(write));
}

std::vector<Write> WriteQueue::Take(absl::Duration patience) {
  std::vector<Write> taken;
  uint64_t bytes = 0;
  MutexLock lock(&mutex_);
  mutex_.AwaitFor([this] { return !waiting_.empty() || stopped_; }, patience);
  while (!waiting_.empty() && bytes < kMostTakenBytes) {
    bytes += waiting_.front().bytes.size();
    taken.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  }
  return taken;
}

void WriteQueue::Answered(uint64_t bytes) {
  MutexLock lock(&mutex_);
  unanswered_bytes_ -= bytes;
}

void WriteQueue::Stop() {
  MutexLock lock(&mutex_);
  stopped_ = true;
}

bool WriteQueue::Ended() const {
  MutexLock lock(&mutex_);
  return stopped_ && waiting_.empty();
}

absl::Status WriteQueue::Admit() const {
  MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(refusal_);
  if (unanswered_bytes_ <= kMostWaitingBytes) return absl::OkStatus();
  return error::StoreBusy(unanswered_bytes_, kMostWaitingBytes);
}

void WriteQueue::SetRefusal(absl::Status refusal) {
  MutexLock lock(&mutex_);
  refusal_ = std::move(refusal);
}

}  // namespace latticed
