// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Logs the time and size of each update of a stream.
//
//   client.Watch(request, [&log](const v1::SceneEvent& event) { log.Take(event); });
//   if (auto status = log.DecodeNewest(surface); …)         // if decoding is measured
//   log.WaitFor(revision)                                   // on any thread
//
// Threads  one calls Take and DecodeNewest; any calls revision, WaitFor and Fail; all else when the
//          first is done
#ifndef LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_
#define LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "client/cpp/library/surface.h"
#include "client/cpp/library/vertex_decoder.h"
#include "core/base/mutex.h"
#include "latticed/v1/event.pb.h"

namespace latticed::client {

struct LoggedUpdate {
  uint64_t revision = 0;
  absl::Time first_chunk;  // equals `end` if no chunk has changed
  absl::Time end;
  absl::Time decoded = absl::InfinitePast();  // InfinitePast: not decoded
  uint64_t bytes = 0;                         // of chunk data
  v1::UpdateTimings timings;
};

class UpdateLog {
 public:
  void Take(const v1::SceneEvent& event);
  // Decodes the chunks that the newest update has brought to a vertex buffer, on all cores.
  [[nodiscard]] absl::Status DecodeNewest(const Surface& surface);

  // The revision of the newest complete update.
  uint64_t revision() const;
  // kDeadlineExceeded after a minute.
  [[nodiscard]] absl::Status WaitFor(uint64_t revision) const;
  // The stream has failed: WaitFor returns this status.
  void Fail(const absl::Status& status);

  const std::vector<LoggedUpdate>& updates() const { return updates_; }
  // Revisions of updates that replaced an update that had not ended.
  const std::vector<uint64_t>& restarts() const { return restarts_; }

 private:
  void TakeEnd(const v1::UpdateEnd& end);

  LoggedUpdate current_;
  std::vector<uint32_t> current_chunks_, newest_chunks_;
  // Of newest_chunks_, one after the other: of the view's grid, or with ENCODING_RAW.
  std::vector<GridVertex> grid_vertices_;
  std::vector<WorldVertex> world_vertices_;
  std::vector<LoggedUpdate> updates_;
  std::vector<uint64_t> restarts_;
  mutable Mutex mutex_;
  uint64_t revision_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_UPDATE_LOG_H_
