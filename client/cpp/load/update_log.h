// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The updates of one stream, as they come: when, and how large.
//
//   client.Watch(request, [&log](const v1::SceneEvent& event) { log.Take(event); });
//   if (auto status = log.DecodeNewest(surface); …)         // where decoding is measured
//   log.SampleNewest(surface);                              // some are kept, to be verified later
//   log.WaitFor(revision, control)                          // in any thread
//
// Threads  one takes and decodes; revision and WaitFor from any; the rest when that one is done
#ifndef LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_
#define LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "client/cpp/library/surface.h"
#include "core/base/mutex.h"
#include "latticed/v1/event.pb.h"

namespace latticed::client {

struct LoggedUpdate {
  uint64_t revision = 0;
  absl::Time first_chunk;  // that of the end where no chunk has changed
  absl::Time end;
  absl::Time decoded = absl::InfinitePast();  // not decoded
  uint64_t bytes = 0;                         // of chunk data
  uint64_t chunks = 0, all_chunks = 0;        // that it has brought, of those of the surface
  v1::UpdateTimings timings;
};

// A few of the chunks that a stream had when an update had ended.
struct SampledUpdate {
  SampledUpdate(const Surface& surface, std::vector<uint32_t> chunks)
      : surface(surface.Excerpt(chunks)), chunks(std::move(chunks)) {}
  Surface surface;
  std::vector<uint32_t> chunks;
};

// Up to `most` numbers below `count`, evenly spread; others for another `offset`.
[[nodiscard]] std::vector<uint32_t> SpreadChunks(size_t count, size_t most, size_t offset);

class UpdateLog {
 public:
  void Take(const v1::SceneEvent& event);
  // Decodes the chunks that the newest update has brought.
  [[nodiscard]] absl::Status DecodeNewest(const Surface& surface);
  // Keeps the 1st, 2nd, 4th, 8th, … update with which it is called: of its chunks some that it has
  // brought, and some of which it says by their absence that they have not changed.
  void SampleNewest(const Surface& surface);

  // Of the newest complete update.
  uint64_t revision() const;
  // kDeadlineExceeded after a minute.
  [[nodiscard]] absl::Status WaitFor(uint64_t revision) const;
  // Wakes who waits: the stream has failed.
  void Fail(const absl::Status& status);

  const std::vector<LoggedUpdate>& updates() const { return updates_; }
  const std::vector<SampledUpdate>& samples() const { return samples_; }
  // The revisions of updates that were begun in place of one that had not ended.
  const std::vector<uint64_t>& restarts() const { return restarts_; }

 private:
  void TakeEnd(const v1::UpdateEnd& end);

  LoggedUpdate current_;
  std::vector<uint32_t> current_chunks_, newest_chunks_;
  uint64_t all_chunks_ = 0;
  std::vector<LoggedUpdate> updates_;
  std::vector<SampledUpdate> samples_;
  uint64_t sampled_from_ = 0;
  std::vector<uint64_t> restarts_;
  mutable Mutex mutex_;
  uint64_t revision_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_
