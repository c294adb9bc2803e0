// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/queue/write_queue.h"

#include <algorithm>
#include <future>
#include <memory>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "server/base/telemetry.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

// Without memory for a list of what waits, its taker tries again after this.
constexpr absl::Duration kMemoryPause = absl::Milliseconds(10);

}  // namespace

void WriteQueue::Put(Write write) {
  MutexLock lock(&mutex_);
  const uint64_t bytes = write.bytes.size();
  waiting_.push_back(std::move(write));
  ++counts_->waiting_writes;
  unanswered_bytes_ += bytes;
  counts_->waiting_bytes = unanswered_bytes_;
}

void WriteQueue::PutAppend(std::string_view scene, uint64_t lsn, std::string record,
                           Store::Done done) {
  Put({.kind = lsn == 0 ? Write::Kind::kBarrier : Write::Kind::kAppend,
       .scene = std::string(scene),
       .lsn = lsn,
       .bytes = std::move(record),
       .done = std::move(done)});
}

void WriteQueue::PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) {
  Put({.kind = Write::Kind::kSnapshot,
       .scene = std::string(scene),
       .lsn = lsn,
       .bytes = std::move(snapshot)});
}

absl::Status WriteQueue::Call(Write::Kind kind, std::function<absl::Status()> change) {
  // Shared: the writer may still be in set_value when the answer is read.
  const auto answer = std::make_shared<std::promise<absl::Status>>();
  Put({.kind = kind, .change = std::move(change), .done = [answer](const absl::Status& status) {
         answer->set_value(status);
       }});
  return answer->get_future().get();
}

std::vector<Write> WriteQueue::Take(absl::Duration patience) {
  while (true) {
    auto taken = CatchBadAlloc("a transaction", [&]() -> absl::StatusOr<std::vector<Write>> {
      return TryToTake(patience);
    });
    if (taken.ok()) return *std::move(taken);
    absl::SleepFor(kMemoryPause);
  }
}

std::vector<Write> WriteQueue::TryToTake(absl::Duration patience) {
  std::vector<Write> taken;
  uint64_t bytes = 0;
  MutexLock lock(&mutex_);
  mutex_.AwaitFor([this] { return !waiting_.empty() || stopped_; }, patience);
  taken.reserve(waiting_.size());
  while (!waiting_.empty() && bytes < kMostTakenBytes) {
    bytes += waiting_.front().bytes.size();
    taken.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  }
  return taken;
}

void WriteQueue::Execute(std::span<Write> writes,
                         const std::function<void(std::span<Write>)>& group,
                         const std::function<void(Write&)>& one) {
  const auto grouped = [](const Write& write) {
    return write.kind == Write::Kind::kAppend || write.kind == Write::Kind::kBarrier;
  };
  while (!writes.empty()) {
    const auto end = std::ranges::find_if_not(writes, grouped);
    const auto count = std::max<size_t>(static_cast<size_t>(end - writes.begin()), 1);
    if (end == writes.begin()) {
      one(writes.front());
    } else {
      group(writes.first(count));
    }
    Answered(writes.first(count));
    writes = writes.subspan(count);
  }
}

void WriteQueue::Count(const Write& write) {
  const bool ok = write.answer.ok();
  if (write.kind == Write::Kind::kAppend) {
    ++(ok ? counts_->appends_stored : counts_->appends_refused);
    if (ok) counts_->append_bytes += write.bytes.size();
  } else if (write.kind == Write::Kind::kSnapshot) {
    ++(ok ? counts_->snapshots_stored : counts_->snapshots_failed);
    if (ok) counts_->snapshot_bytes += write.bytes.size();
  }
}

void WriteQueue::Answer(Write& write) {
  Count(write);
  if (write.kind == Write::Kind::kSnapshot && !write.answer.ok()) {
    LogEvent(spdlog::level::warn, "snapshot not stored",
             {{"scene", write.scene}, {"error", std::string(write.answer.message())}});
  }
  // What `done` holds is gone before the next answer.
  const Store::Done done = std::exchange(write.done, nullptr);
  if (done == nullptr) return;
  const absl::Status status = CatchBadAlloc("an answer of the store", [&] {
    done(write.answer);
    return absl::OkStatus();
  });
  if (status.ok()) return;
  LogEvent(spdlog::level::err, "an answer of the store was lost",
           {{"scene", write.scene}, {"error", std::string(status.message())}});
}

void WriteQueue::Answered(std::span<const Write> writes) {
  MutexLock lock(&mutex_);
  for (const Write& write : writes) unanswered_bytes_ -= write.bytes.size();
  counts_->waiting_writes -= writes.size();
  counts_->waiting_bytes = unanswered_bytes_;
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
  if (refusal_.ok() && !refusal.ok()) ++counts_->failures;
  counts_->writable = refusal.ok();
  refusal_ = std::move(refusal);
}

}  // namespace latticed
