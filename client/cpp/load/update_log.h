// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The updates of one stream as they come: time and size of each.
//
//   client.Watch(request, [&log](const v1::SceneEvent& event) { log.Take(event); });
//   if (auto status = log.DecodeNewest(surface); …)         // where decoding is measured
//   log.WaitFor(revision)                                   // in any thread
//
// Threads  one takes and decodes; revision and WaitFor from any; the rest when that thread is done
#ifndef LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_
#define LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "client/cpp/library/surface.h"
#include "core/base/mutex.h"
#include "latticed/v1/event.pb.h"

namespace latticed::client {

struct LoggedUpdate {
  uint64_t revision = 0;
  absl::Time first_chunk;  // equals `end` where no chunk has changed
  absl::Time end;
  absl::Time decoded = absl::InfinitePast();  // not decoded
  uint64_t bytes = 0;                         // of chunk data
  v1::UpdateTimings timings;
};

class UpdateLog {
 public:
  void Take(const v1::SceneEvent& event);
  // Decodes the chunks that the newest update has brought.
  [[nodiscard]] absl::Status DecodeNewest(const Surface& surface);

  // The revision of the newest complete update.
  uint64_t revision() const;
  // kDeadlineExceeded after a minute.
  [[nodiscard]] absl::Status WaitFor(uint64_t revision) const;
  // The stream has failed: WaitFor returns this status.
  void Fail(const absl::Status& status);

  const std::vector<LoggedUpdate>& updates() const { return updates_; }
  // Revisions of updates that replaced one that had not ended.
  const std::vector<uint64_t>& restarts() const { return restarts_; }

 private:
  void TakeEnd(const v1::UpdateEnd& end);

  LoggedUpdate current_;
  std::vector<uint32_t> current_chunks_, newest_chunks_;
  std::vector<LoggedUpdate> updates_;
  std::vector<uint64_t> restarts_;
  mutable Mutex mutex_;
  uint64_t revision_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_
