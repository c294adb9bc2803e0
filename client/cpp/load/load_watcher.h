// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One watcher of a load, with a connection and a thread of its own. It keeps up, reads a given
// number of bytes per second, or reads one update and then nothing.
//
// Errors   the server's; those after Open end the run (LoadControl)
// Threads  one at a time; log() like UpdateLog, surface() only after Close
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_WATCHER_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_WATCHER_H_

#include <memory>
#include <thread>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "client/cpp/library/latticed_client.h"
#include "client/cpp/load/load_control.h"
#include "client/cpp/load/update_log.h"

namespace latticed::client {

class LoadWatcher {
 public:
  enum class Pace { kFull, kSlow, kStalled };
  struct Options {
    Pace pace = Pace::kFull;
    double bytes_per_second = 0;  // kSlow
    bool decodes = false;
  };

  // Returns with the first update. A stalled watcher does not acknowledge, so that only the
  // transport holds the server up.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<LoadWatcher>> Open(
      std::unique_ptr<Client> client, v1::WatchRequest request, const Options& options,
      LoadControl* control);
  LoadWatcher(const LoadWatcher&) = delete;  // its thread uses it
  LoadWatcher& operator=(const LoadWatcher&) = delete;
  ~LoadWatcher() { Close(); }
  // Ends the stream and the thread. Idempotent.
  void Close();

  Pace pace() const { return options_.pace; }
  const UpdateLog& log() const { return log_; }
  const Surface& surface() const { return stream_->surface(); }

 private:
  LoadWatcher(std::unique_ptr<Client> client, const Options& options, LoadControl* control);
  void Take(const v1::SceneEvent& event);
  void Read();

  const std::unique_ptr<Client> client_;
  const Options options_;
  LoadControl* const control_;
  UpdateLog log_;
  bool open_ = false;  // a slow watcher is slow from then on
  absl::Notification closing_;
  std::unique_ptr<WatchStream> stream_;  // uses client_ and log_
  std::thread thread_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_WATCHER_H_
