// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/update_log.h"

#include <algorithm>
#include <span>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "tbb/blocked_range.h"
#include "tbb/parallel_for.h"

namespace latticed::client {
namespace {

constexpr absl::Duration kPatience = absl::Seconds(60);

}  // namespace

void UpdateLog::Take(const v1::SceneEvent& event) {
  switch (event.event_case()) {
    case v1::SceneEvent::kUpdateBegin:
      if (event.update_begin().restart()) restarts_.push_back(event.update_begin().revision());
      current_ = {.first_chunk = absl::InfiniteFuture()};
      current_chunks_.clear();
      break;
    case v1::SceneEvent::kChunks:
      if (current_chunks_.empty()) current_.first_chunk = absl::Now();
      for (const v1::Chunk& chunk : event.chunks().chunks()) {
        for (uint32_t i = 0; i < std::max(chunk.chunk_count(), 1u); ++i) {
          current_chunks_.push_back(chunk.index() + i);
        }
        current_.bytes += chunk.data().size();
      }
      break;
    case v1::SceneEvent::kUpdateEnd:
      TakeEnd(event.update_end());
      break;
    default:
      break;
  }
}

void UpdateLog::TakeEnd(const v1::UpdateEnd& end) {
  current_.end = absl::Now();
  if (current_chunks_.empty()) current_.first_chunk = current_.end;
  current_.revision = end.revision();
  current_.timings = end.timings();
  updates_.push_back(std::exchange(current_, {}));
  newest_chunks_ = std::exchange(current_chunks_, {});
  const MutexLock lock(&mutex_);
  revision_ = end.revision();
}

absl::Status UpdateLog::DecodeNewest(const Surface& surface) {
  constexpr size_t kChunksOfATask = 16;
  const std::span<const uint32_t> chunks = newest_chunks_;
  Mutex mutex;
  absl::Status status;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, chunks.size(), kChunksOfATask),
                    [&](const tbb::blocked_range<size_t>& task) {
                      const auto decoded =
                          surface.Decode(chunks.subspan(task.begin(), task.size()));
                      const MutexLock lock(&mutex);
                      status.Update(decoded.status());
                    });
  LATTICED_RETURN_IF_ERROR(status);
  updates_.back().decoded = absl::Now();
  return absl::OkStatus();
}

uint64_t UpdateLog::revision() const {
  const MutexLock lock(&mutex_);
  return revision_;
}

absl::Status UpdateLog::WaitFor(uint64_t revision) const {
  const MutexLock lock(&mutex_);
  const bool in_time =
      mutex_.AwaitFor([&] { return revision_ >= revision || !status_.ok(); }, kPatience);
  if (!status_.ok()) return status_;
  if (in_time) return absl::OkStatus();
  return absl::DeadlineExceededError(
      fmt::format("a stream is still at revision {} of {} after a minute", revision_, revision));
}

void UpdateLog::Fail(const absl::Status& status) {
  const MutexLock lock(&mutex_);
  status_.Update(status);
}

}  // namespace latticed::client
