// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/update_log.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "tbb/parallel_for.h"

namespace latticed::client {
namespace {

constexpr absl::Duration kPatience = absl::Seconds(60);
constexpr size_t kChunksOfATask = 16;

// Decodes chunks one after the other into `vertices`, which keeps its memory.
template <class Vertex>
absl::Status DecodeOnAllCores(const Surface& surface, std::span<const uint32_t> chunks,
                              std::vector<Vertex>* vertices) {
  std::vector<size_t> begins{0};  // of each task's vertices, and the end
  for (size_t first = 0; first < chunks.size(); first += kChunksOfATask) {
    const size_t count = std::min(kChunksOfATask, chunks.size() - first);
    LATTICED_ASSIGN_OR_RETURN(const uint64_t points,
                              surface.PointCount(chunks.subspan(first, count)));
    begins.push_back(begins.back() + points);
  }
  if (vertices->size() < begins.back()) vertices->resize(begins.back());
  Mutex mutex;
  absl::Status status;
  tbb::parallel_for(size_t{0}, begins.size() - 1, [&](size_t task) {
    thread_local VertexDecoder decoder;
    const size_t first = task * kChunksOfATask;
    const auto decoded = surface.Decode(
        chunks.subspan(first, std::min(kChunksOfATask, chunks.size() - first)), &decoder,
        std::span(*vertices).subspan(begins[task], begins[task + 1] - begins[task]));
    const MutexLock lock(&mutex);
    status.Update(decoded);
  });
  return status;
}

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
  const bool has_grid = surface.view().encoding() != v1::ENCODING_RAW;
  LATTICED_RETURN_IF_ERROR(has_grid ? DecodeOnAllCores(surface, newest_chunks_, &grid_vertices_)
                                    : DecodeOnAllCores(surface, newest_chunks_, &world_vertices_));
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
